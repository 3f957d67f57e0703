"""The command line: help, list, check, table, and what it says when a command is wrong."""

import contextlib
import io
import os
import pty
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from command import PROCESS, STUDIES, STUDY, changed, ran, workbench, write

from controllers.registry import controllers
from plants.registry import plants
from workbench.cli import main
from workbench.metrics.registry import columns
from workbench.parameters.sets import named_sets
from workbench.study.reference_tables import REFERENCES


def test_list_names_all_that_a_study_may_name() -> None:
    everything = workbench("list")
    assert (everything.code, everything.err) == (0, "")
    words = set(everything.out.replace(",", " ").split())
    assert {*plants(), *controllers(), *named_sets(), *REFERENCES.working(), *columns(), "by_rpm", "rk4", "kp"} <= words
    sections = [
        workbench("list", kind).out
        for kind in ("plants", "friction_laws", "controllers", "parameters", "machines", "scenarios", "references")
    ]
    assert everything.out.startswith("".join(sections))
    assert workbench("list", "references").out.splitlines()[1].split(maxsplit=1) == [
        "sine",
        "amplitude, frequency, offset, phase",
    ]


def listed(controller: str) -> dict[str, list[str]]:
    """What the list shows of a controller: the settings under each of its headings, and its signals."""
    lines = workbench("list", "controllers").out.splitlines()[1:]
    start = next(i for i, line in enumerate(lines) if line.startswith(f"  {controller} "))
    found: dict[str, list[str]] = {"": []}
    heading = ""
    for line in lines[start + 1 :]:
        if not line.startswith("    "):
            break
        if line.startswith("    signals: "):
            found["signals"] = line.removeprefix("    signals: ").split(", ")
        elif line.startswith("    with "):
            heading = line.removeprefix("    with ")
            found[heading] = []
        else:
            found[heading].append(line.split()[0])
    return found


def test_list_shows_of_each_controller_what_it_can_use() -> None:
    adaptive = listed("lugre_adaptive")
    assert adaptive[""] == ["law", "injection", "adaptation", "velocity", "rotation"]
    assert adaptive["law = valve_inversion"] == ["position_rate", "force_rate", "compression"]
    assert adaptive["law = valve_inversion or acceleration_feedback"] == ["lead"]
    assert adaptive["rotation = measured"] == ["rotation_time_constant"]
    assert adaptive["velocity = kalman"] == ["position_noise", "jerk_density"]
    assert {"controller_theta", "controller_friction"} <= set(adaptive["signals"])
    assert listed("friedland_park")[""] == ["law", "observer_gain", "exponent", "velocity", "rotation"]
    assert listed("load_pressure")[""] == ["law", "pressure_time_constant"]
    assert listed("pid")["ki not 0"] == ["tracking_time"]


def test_list_says_what_each_setting_means() -> None:
    words = [" ".join(line.split()) for line in workbench("list", "controllers").out.splitlines()]
    assert "kp command/m needed gain on the position error; >= 0; tuned from 0.1 to 10 times the study's" in words
    assert "retained 1 default 0.0 share of the integral that outlives a reversal; 0 to 1; tuned from 0 to 1" in words
    assert "hold choice default linear how it goes on between samples; linear | zero" in words


def test_list_of_scenarios() -> None:
    """The shipped ones, wherever one stands."""
    assert "  nominal                The plant as it is believed to be\n" in workbench("list", "scenarios").out


def test_list_of_nothing() -> None:
    assert workbench("list", "plant") == (2, "", 'error: nothing called "plant" to list; did you mean "plants"?\n')


@pytest.mark.parametrize(
    "path", sorted({*STUDIES.glob("*.toml")} - {STUDIES / "closed_loop.toml"}), ids=lambda path: path.stem
)
def test_every_study_is_in_order(path: Path) -> None:
    answer = workbench("check", path)
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.startswith(f"{path}: a study, in order\n")


@pytest.mark.parametrize("path", named_sets().values(), ids=list(named_sets()))
def test_every_parameter_set_is_in_order(path: Path) -> None:
    answer = workbench("check", path)
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.startswith(f"{path}: a parameter set of ")


def test_what_a_parameter_set_lacks_is_said_of_plants_that_are_near_to_it_alone() -> None:
    lines = workbench("check", named_sets()["canudas1995"]).out.splitlines()
    assert lines[1].startswith("  serves drive_force")
    assert "  does not serve drive_voltage: the parameter set lacks force_gain" in lines
    assert lines[-1].startswith("  lacks more than 6 parameters of non_rotating, ")
    assert sum("lacks" in line for line in lines[2:]) == len(lines) - 2


def test_check_says_what_a_study_would_do(tmp_path: Path) -> None:
    path = write(tmp_path, STUDY + "[cases.a]\n[cases.b]\naxes = {}\n")
    expected = "a study for tests\n  case: a, b\n  rpm: 0, 460\n  3 cases, 3 s of simulated time\n"
    assert workbench("check", path) == (0, f"{path}: a study, in order\n{expected}", "")
    assert workbench("check", write(tmp_path, changed("0, 460", "0"))).out.endswith("  1 case, 1 s of simulated time\n")


def test_check_of_a_wrong_parameter_set(tmp_path: Path) -> None:
    path = write(tmp_path, 'title = "a"\nsource = "b"\n[parameters.mas]\nvalue = "1 kg"\nsource = "c"\n')
    expected = f'error: {path}:4: parameters.mas.value: unknown parameter "mas"; did you mean "mass"?\n'
    assert workbench("check", path) == (2, "", expected)


@pytest.mark.parametrize(
    "arguments", [("rnu",), ("run",), ("run", "a.toml"), ("run", "a.toml", "--out", "b", "--jobs", "0")]
)
def test_a_wrong_command(arguments: tuple[str, ...]) -> None:
    answer = workbench(*arguments)
    assert (answer.code, answer.out) == (2, "")
    assert "Traceback" not in answer.err
    assert answer.err.rstrip().splitlines()[-1].startswith("Error: ")


def test_debug_shows_the_traceback(tmp_path: Path) -> None:
    path = write(tmp_path, changed("by_rpm", "by_rmp"))
    plain = workbench("check", path)
    assert plain.code == 2
    assert plain.err.count("\n") == 1
    command = [*PROCESS, "--debug", "check", str(path)]
    debug = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "Traceback" in debug.stderr
    assert 'did you mean "by_rpm"?' in debug.stderr


def test_a_progress_bar_on_a_terminal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The number of cases done, and the last one, are written to a terminal alone."""
    ours, theirs = pty.openpty()
    monkeypatch.setenv("TERM", "xterm")
    words = ["run", str(write(tmp_path, STUDY)), "--out", str(tmp_path / "out"), "--jobs", "1"]
    monkeypatch.setattr("sys.argv", ["workbench", *words])
    with ThreadPoolExecutor(1) as reader:
        shown = reader.submit(all_of, ours)
        with open(theirs, "w", encoding="utf-8") as terminal, contextlib.redirect_stdout(io.StringIO()):
            monkeypatch.setattr("sys.stderr", terminal)
            with pytest.raises(SystemExit) as ended:
                main()
            monkeypatch.undo()
    assert not ended.value.code
    assert b"2/2" in shown.result()
    assert b"rpm 460" in shown.result()


def all_of(terminal: int) -> bytes:
    """What is written at the other end of a terminal, until that is closed."""
    shown = b""
    with contextlib.suppress(OSError):  # how Linux says that the other end is closed
        while part := os.read(terminal, 65536):
            shown += part
    os.close(terminal)
    return shown


# --- table ---


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of the study, which are looked at alone."""
    return ran(tmp_path_factory.mktemp("results"), STUDY)


def test_columns_of_results(results: Path) -> None:
    answer = workbench("table", results, "--column", "outcome", "--column", "gain_ratio")
    assert answer.code == 0
    head, _, *lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in answer.out.splitlines()]
    assert head == ["rpm", "outcome", "gain_ratio"]
    assert [line[:2] for line in lines] == [["0", "completed"], ["460", "torque-limited"]]  # 47 N m for a motor of 23
    one = workbench("table", results, "--column", "gain_ratio", "--where", "rpm=460").out.splitlines()
    assert len(one) == 3
    assert one[-1].split("|")[1].strip() == "460"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ((), "@: its study asks for no tables; choose columns with --column"),
        (("--column", "gain_rato"), 'the results have no column "gain_rato"; did you mean "gain_ratio"?'),
        (("--where", "rmp=0"), 'the results have no column "rmp"; did you mean "rpm"?'),
        (("--where", "rpm=1"), "no case has rpm 1"),
        (("--where", "rpm"), '--where "rpm": expected AXIS=VALUE, such as rpm=460'),
    ],
)
def test_a_table_that_cannot_be(results: Path, options: tuple[str, ...], said: str) -> None:
    answer = workbench("table", results, *options)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.replace(str(results), "@") == f"error: {said}\n"


@pytest.mark.parametrize("command", ["table", "plot"])
def test_no_results(tmp_path: Path, command: str) -> None:
    expected = f"error: {tmp_path}: holds no finished results; run a study with --out {tmp_path} first\n"
    assert workbench(command, tmp_path) == (2, "", expected)


def test_damaged_results(tmp_path: Path) -> None:
    out = ran(tmp_path, STUDY)
    (out / "results.parquet").write_bytes(b"PAR1")
    answer = workbench("table", out)
    assert answer.code == 2
    assert answer.err.startswith(f"error: {out / 'results.parquet'}: cannot be read (")
    assert workbench("run", tmp_path / "study.toml", "--out", out, "--resume").code == 0
    assert workbench("table", out, "--column", "outcome").code == 0


def test_a_place_that_cannot_be_written_is_one_line(tmp_path: Path, results: Path) -> None:
    write(tmp_path, "mine", "file")
    answer = workbench("plot", results, "--y", "gain_ratio", "--x", "rpm", "--out", tmp_path / "file" / "a.png")
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith(f"error: {tmp_path / 'file'}: ")
    assert answer.err.count("\n") == 1


RESUMED = "finished cases are kept in {out}: go on with --resume"


@pytest.mark.parametrize(
    ("command", "file", "stopped", "kept"),
    [
        ("diagnose", "closed_loop/experiment.toml", "diagnose.diagnose.diagnose", "nothing is written"),
        ("design", "closed_loop/experiment.toml", "design.design.design", "nothing is written"),
        ("identify", "closed_loop/experiment.toml", "identify.identification.identify", "nothing is written"),
        ("run", "hunting.toml", "study.rounds.run_rounds", RESUMED),
    ],
)
def test_a_stop_is_told_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str, file: str, stopped: str, kept: str
) -> None:
    def kill(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(f"workbench.{stopped}", kill)
    out = tmp_path / "out"
    ended = workbench(command, STUDIES / file, "--out", out)
    assert (ended.code, ended.err) == (130, f"stopped; {kept.format(out=out)}\n")
    assert not out.exists()
