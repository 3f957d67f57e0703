"""Whatever runs can be stopped: loops from another thread, commands and their workers by signals."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import pytest
from command import PROCESS, changed, write
from support import OSCILLATOR, start

import workbench.stopping as stopping
from workbench.cli.app import mistakes_told
from workbench.cli.progress import stoppable
from workbench.parallel.chunks import Worker
from workbench.simulation.setup import Integrator
from workbench.simulation.simulate import simulate

SIGNALS = pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)], ids=["SIGINT", "SIGTERM"]
)

FOR_EVER = changed('transient = "0.4 s"', 'transient = "0.4 s"\nmethod = "rk4"\nstep = "1e-10 s"')
"""The most steps that a study may have: some minutes of one case."""

WORKERS = """\
import multiprocessing, sys, time
from concurrent.futures import ProcessPoolExecutor
from workbench.cli.progress import say_stopped, stoppable
from workbench.stopping import in_a_worker, stopping_on_signals
with stopping_on_signals(say_stopped), stoppable():
    spawning = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, spawning, initializer=in_a_worker) as pool:
        pool.submit(time.sleep, 0.0).result()
        slept = pool.submit(time.sleep, 600.0)
        print("ready", flush=True)
        slept.result()
"""
"""A process that waits for a worker."""

HOLDS_ON = """\
import os, signal, sys, time
import workbench.stopping as stopping
from workbench.cli.app import mistakes_told
from workbench.cli.progress import stoppable
stopping.GRACE = 0.1
with stopping.stopping_on_signals(lambda: print("said", file=sys.stderr, flush=True)):
    try:
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(600.0)
    except KeyboardInterrupt:
        time.sleep(600.0)
"""
"""A process that is told and does not end."""


DROPS = """\
import os, signal, time
from workbench.cli.progress import say_stopped, stoppable
from workbench.stopping import stopping_on_signals
with stopping_on_signals(say_stopped), stoppable("all is well"):
    try:
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(600.0)
        except BaseException:
            pass
        time.sleep(600.0)
    finally:
        time.sleep(0.5)
        print("tidied", flush=True)
"""
"""A process in which something drops the interruption, and which takes its time to tidy up after the next."""


LATE = """\
import atexit, os, signal, sys
from workbench.cli import main
atexit.register(os.kill, os.getpid(), signal.SIGINT)
atexit.register(print, "ending", flush=True)
sys.argv = ["workbench", sys.argv[1]]
main()
"""
"""A command that is asked to stop while Python ends."""


ENDING = """\
import os, signal, sys, threading
from workbench.cli import main
threading._register_atexit(os.kill, os.getpid(), signal.SIGINT)
sys.argv = ["workbench", "list"]
main()
"""
"""A command that is asked to stop while Python waits for threads, before anything that is registered to be done."""


@pytest.fixture(autouse=True)
def _clear() -> Iterator[None]:
    yield
    stopping.clear()


@pytest.mark.parametrize(
    ("integrator", "sample_time"),
    [(Integrator("rk4", 1e-12), 1e-3), (Integrator("dormand_prince"), 1e7), (Integrator("bogacki_shampine"), 1e7)],
)
def test_a_loop_ends_when_another_thread_asks(integrator: Integrator, sample_time: float) -> None:
    setup = start(
        OSCILLATOR, 1.0, stiffness=1e4, duration=2.0 * sample_time, integrator=integrator, sample_time=sample_time
    )
    with ThreadPoolExecutor(1) as thread:
        run = thread.submit(simulate, setup)
        time.sleep(0.1)
        assert not run.done()
        stopping.request()
        assert isinstance(run.exception(timeout=60.0), KeyboardInterrupt)


def test_no_loop_begins_until_the_flag_is_cleared() -> None:
    setup = start(OSCILLATOR, duration=0.01)
    stopping.request()
    with pytest.raises(KeyboardInterrupt):
        simulate(setup)
    stopping.clear()
    assert simulate(setup).time.size == 11


@contextmanager
def begun(*command: str) -> Iterator[subprocess.Popen[str]]:
    """A process at the head of its own group, killed where the test fails before it ends."""
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)


@SIGNALS
def test_a_signal_ends_a_command_that_is_in_compiled_code(tmp_path: Path, number: int, code: int) -> None:
    out = tmp_path / "out"
    with begun(*PROCESS, "run", str(write(tmp_path, FOR_EVER)), "--out", str(out)) as process:
        deadline = time.monotonic() + 60.0
        while not any(out.glob("*")) and time.monotonic() < deadline:
            time.sleep(0.05)
        time.sleep(0.3)
        assert process.poll() is None
        process.send_signal(number)
        _, said = process.communicate(timeout=60.0)
    assert (process.returncode, said) == (code, f"stopped; finished cases are kept in {out}: go on with --resume\n")


@SIGNALS
@pytest.mark.parametrize("sent", [os.kill, os.killpg], ids=["to the command", "to all its processes"])
def test_a_signal_ends_workers_without_a_word_of_theirs(
    sent: Callable[[int, int], None], number: int, code: int
) -> None:
    with begun(sys.executable, "-c", WORKERS) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        sent(process.pid, number)
        _, said = process.communicate(timeout=60.0)
    assert (process.returncode, said) == (code, "stopped; nothing is written\n")


def begins_late() -> None:
    """A worker's beginning, on a machine that has much to do."""
    time.sleep(0.3)
    stopping.in_a_worker()
    time.sleep(60.0)


def test_a_worker_that_is_ended_before_it_has_begun_stops_nothing_else() -> None:
    with stopping.stopping_on_signals(lambda: None):
        worker = Worker(target=begins_late)
        worker.start()
        worker.terminate()
        worker.join(30.0)
        asked = stopping.is_requested()
    assert (worker.exitcode, asked) == (-signal.SIGTERM, False)


def test_what_holds_on_ends_with_the_process() -> None:
    done = subprocess.run([sys.executable, "-c", HOLDS_ON], capture_output=True, text=True, timeout=60.0)
    assert (done.returncode, done.stdout, done.stderr) == (143, "", "said\n")


def test_what_is_dropped_is_raised_again_and_what_tidies_up_is_left_alone() -> None:
    """An import of a library drops every exception; the next one comes at once, and no other while it is handled."""
    done = subprocess.run([sys.executable, "-c", DROPS], capture_output=True, text=True, timeout=60.0)
    assert (done.returncode, done.stdout, done.stderr) == (143, "tidied\n", "stopped; all is well\n")


def test_handlers_are_as_before() -> None:
    before = [signal.getsignal(number) for number in stopping.SIGNALS]
    said: list[str] = []

    def stopped() -> None:
        with stopping.stopping_on_signals(lambda: said.append("stopped")):
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(60.0)

    with pytest.raises(KeyboardInterrupt):
        stopped()
    assert [signal.getsignal(number) for number in stopping.SIGNALS] == before
    assert signal.set_wakeup_fd(-1) == -1
    assert simulate(start(OSCILLATOR, duration=0.01)).time.size == 11
    assert said == []


@pytest.mark.parametrize(("argument", "code"), [("--help", 0), ("--halp", 2)])
def test_a_signal_that_comes_while_python_ends_changes_nothing(argument: str, code: int) -> None:
    done = subprocess.run([sys.executable, "-c", LATE, argument], capture_output=True, text=True, timeout=60.0)
    assert done.returncode == code
    assert "ending" in done.stdout
    assert "KeyboardInterrupt" not in done.stderr


@pytest.mark.parametrize(
    ("error", "asked", "ends"),
    [
        (ImportError("initialization failed"), signal.SIGTERM, 143),
        (OSError("interrupted"), signal.SIGINT, 130),
        (ImportError("no such module"), None, None),
    ],
)
def test_what_a_library_makes_of_an_interrupt_is_told_as_a_stop(
    error: Exception, asked: int | None, ends: int | None, capsys: pytest.CaptureFixture[str]
) -> None:
    """A compiled module that is interrupted while it is imported says ImportError."""

    def work() -> None:
        with stoppable("all is kept"), mistakes_told():
            if asked is not None:
                stopping.request(asked)
            raise error

    if ends is None:
        with pytest.raises(ImportError):
            work()
        return
    with pytest.raises(SystemExit) as ended:
        work()
    assert (ended.value.code, capsys.readouterr().err) == (ends, "stopped; all is kept\n")


DROPPED = """
import gc, os, signal, sys
from workbench.stopping import is_requested, stopping_on_signals

class Held:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)
        print("not reached")

with stopping_on_signals(lambda: None):
    Held()
    print(is_requested())
"""
"""A signal that comes in a finaliser, from which Python lets no exception out."""


def test_an_interrupt_that_python_drops_is_no_noise_and_stops_nevertheless() -> None:
    done = subprocess.run([sys.executable, "-c", DROPPED], capture_output=True, text=True, timeout=60.0)
    assert (done.returncode, done.stdout, done.stderr) == (0, "True\n", "")


def test_a_signal_while_python_ends_says_nothing() -> None:
    done = subprocess.run([sys.executable, "-c", ENDING], capture_output=True, text=True, timeout=60.0)
    assert (done.returncode, done.stderr) == (0, "")
