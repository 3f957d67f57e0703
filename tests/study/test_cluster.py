"""Commands on a dask cluster: the same bytes, whoever is lost, and a line where the scheduler is."""

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, suppress
from pathlib import Path

import kills
import pytest
from command import PROCESS, STUDY, changed, ran, workbench, write
from kill_studies import COMMANDS

pytest.importorskip("distributed")

RECORDS = 'records = ["position"]\n'

SLOW = (
    RECORDS
    + changed('"1 s"', '"0.3 s"')
    .replace('"0.4 s"', '"0.1 s"')
    .replace("2 Hz", "20 Hz")
    .replace("[0, 460]", '[0, 460]\n"controllers.p.kp" = [100, 200, 300, 400]\n"simulation.seed" = [1, 2, 3, 4, 5]')
    + 'method = "rk4"\nstep = "1 us"\n'
)
"""40 cases that take a while each, and leave a file each."""


class Cluster:
    """A scheduler and its workers, each a process of its own."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._started: list[subprocess.Popen[bytes]] = []
        with closing(socket.socket()) as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{port}"
        self.scheduler = self._begin("scheduler", "--host", "127.0.0.1", "--port", str(port))

    def worker(self) -> subprocess.Popen[bytes]:
        """One more worker, with one thread, in this process's environment."""
        number = str(len(self._started))
        return self._begin(
            "worker", self.address, "--nthreads", "1", "--no-nanny", "--local-directory", str(self._folder / number)
        )

    def _begin(self, kind: str, *arguments: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", "--no-dashboard", *arguments]
        log = (self._folder / f"{len(self._started)}.log").open("wb")
        self._started.append(subprocess.Popen(command, stdout=log, stderr=log, start_new_session=True))
        log.close()
        return self._started[-1]

    def close(self) -> None:
        """End all that was begun."""
        for process in reversed(self._started):
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@pytest.fixture
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    with closing(Cluster(tmp_path_factory.mktemp("cluster"))) as begun:
        yield begun


second_cluster = cluster


def until(condition: Callable[[], bool]) -> None:
    for _ in range(4000):
        if condition():
            return
        time.sleep(0.05)
    pytest.fail("waited in vain")


def records(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted((folder / "records").glob("*.parquet"))}


def begun(arguments: Sequence[object]) -> subprocess.Popen[str]:
    return subprocess.Popen([*PROCESS, *map(str, arguments)], stderr=subprocess.PIPE, text=True)


def ends_with_its_scheduler(running: subprocess.Popen[str], cluster: Cluster) -> None:
    """What a command that is `running` says when the scheduler is killed."""
    cluster.scheduler.kill()
    began = time.monotonic()
    _, said = running.communicate(timeout=200.0)
    assert time.monotonic() - began < 60.0, "waits for nobody who has gone"
    assert running.returncode == 2
    assert said.splitlines()[-1] == (
        f"error: {cluster.address}: the scheduler has gone; what is finished is kept: go on with --resume"
    )
    assert "Traceback" not in said


def test_a_lost_worker_costs_nothing_and_a_lost_scheduler_a_line(tmp_path: Path, cluster: Cluster) -> None:
    """One of two workers is killed, then the scheduler; resumed here, the folder is that of an undisturbed run."""
    first, _ = cluster.worker(), cluster.worker()
    out = tmp_path / "out"
    arguments = ["run", write(tmp_path, SLOW), "--out", out, "--cluster", cluster.address]
    running = begun(arguments)
    until(lambda: len(records(out)) > 2)
    first.kill()
    done = len(records(out))
    until(lambda: len(records(out)) > done + 4)
    ends_with_its_scheduler(running, cluster)
    assert workbench("run", tmp_path / "study.toml", "--out", out, "--resume").code == 0
    alone = ran(tmp_path, SLOW)
    assert (out / "results.csv").read_bytes() == (alone / "results.csv").read_bytes()
    assert records(out) == records(alone)


@pytest.mark.parametrize(("name", "results"), [("tune", "trials.csv"), ("decide", "draws.parquet")])
def test_other_commands_go_on_on_another_cluster(
    tmp_path: Path, cluster: Cluster, second_cluster: Cluster, name: str, results: str
) -> None:
    """A worker is lost, then the scheduler; another cluster ends it, and the folder is that of an undisturbed run."""
    command, out, whole = COMMANDS[name], tmp_path / "out", tmp_path / "whole"
    command.make(tmp_path)
    words, first = command.arguments(tmp_path, 1), cluster.worker()
    cluster.worker()
    running = begun([*words, "--out", out, "--cluster", cluster.address])
    until(lambda: kills.rows(command, out) > 2)
    first.kill()
    done = kills.rows(command, out)
    until(lambda: kills.rows(command, out) > done + 2)
    ends_with_its_scheduler(running, cluster)
    second_cluster.worker()
    assert workbench(*words, "--out", out, "--resume", "--cluster", second_cluster.address).code == 0
    assert workbench(*words, "--out", whole).code == 0
    assert (out / results).read_bytes() == (whole / results).read_bytes()


def refused(folder: Path, cluster: Cluster, change: str) -> str:
    """What a run on a cluster says that ends with an error; `change` is done to the program first."""
    code = f"from workbench.cli import main\n{change}\nmain()"
    arguments = ["run", write(folder, STUDY), "--out", folder / "out", "--cluster", cluster.address]
    answer = subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True, timeout=200.0, check=False
    )
    assert answer.returncode == 2
    return answer.stderr


def test_no_worker_is_told(tmp_path: Path, cluster: Cluster) -> None:
    assert refused(tmp_path, cluster, "from workbench.parallel import cluster; cluster.WITHOUT = 1.0") == (
        f"error: {cluster.address}: no worker for 1 s; start one with: dask worker {cluster.address}; "
        "what is finished is kept: go on with --resume\n"
    )


def test_a_worker_of_another_version_is_told(tmp_path: Path, cluster: Cluster) -> None:
    cluster.worker()
    said = refused(tmp_path, cluster, "from workbench.study import plan; plan.source_hash = lambda folders: 'another'")
    assert said.endswith("has another version of this program; install the same one there\n")
