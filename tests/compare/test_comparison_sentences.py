"""Every sentence of the page is derived again from the rows, by independent code; one that none knows fails."""

import re
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from comparison_reader import WATTS, Reader
from comparison_rows import CANDIDATE, NUMBER, PRESSURE, Rows, interval, same
from made_up_comparison import SPEC, made_up_study, whole

from workbench.compare.comparison import compare
from workbench.compare.report.page import write_comparison
from workbench.compare.section import COMPARISON


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory, dots_alone: None) -> tuple[list[str], Rows]:
    """The lines of a page of made-up results, and their rows."""
    folder = tmp_path_factory.mktemp("page")
    search, fresh = whole(noise=0.2), whole(2, range(11, 27), noise=0.2)  # so that some verdicts are unsure
    again = COMPARISON.again(SPEC, search, None)
    assert again is not None
    chosen = pd.DataFrame(again.wanted)
    fresh = fresh.merge(chosen, on=list(chosen.columns))
    comparison = compare(made_up_study("Which", "compensate or avoid?"), SPEC, search, fresh)
    markdown = write_comparison(comparison, folder)[0].read_text(encoding="utf-8")
    return markdown.splitlines(), Rows(search, fresh)


def section(lines: list[str], title: str) -> list[str]:
    """The bullets under a heading."""
    start = lines.index(f"## {title}") + 1
    end = next((i for i in range(start, len(lines)) if lines[i].startswith("## ")), len(lines))
    return [line[2:] for line in lines[start:end] if line.startswith("- ")]


def split(text: str) -> list[str]:
    return re.split(r"(?<=\.) (?=[A-Z])", text)


def test_every_sentence_about_a_cell(page: tuple[list[str], Rows]) -> None:
    lines, rows = page
    bullets = [*section(lines, "Nominal"), *section(lines, "Soft")]
    told = set()
    for cell in rows.cells():
        start = f"{cell.machine.capitalize()} {cell.scenario} {cell.reference}: "
        (line,) = [line for line in bullets if line.startswith(start)]
        for sentence in split(line.removeprefix(start)):
            Reader(rows, cell).read(sentence)
            told.add(sentence.split(":")[0].split(" of ")[0])
        bullets.remove(line)
    assert len(told) > 4, "the made-up results lead to few kinds of sentences"
    for line in bullets:
        _hunting(line, pd.concat([rows.search, rows.fresh], ignore_index=True))


def _hunting(line: str, search: pd.DataFrame) -> None:
    match = re.match(r"Hunting, (\w+) (\w+): (none|\d+) of (\d+) cases that hold still\. ?(.*)", line)
    assert match, line
    machine, scenario, count, of, rest = match.groups()
    part = search[(search["machine"] == machine) & (search["scenario"] == scenario) & (search["reference"] == "steps")]
    swings = part["limit_cycle"].isin(["sustained", "too_short"])
    assert (0 if count == "none" else int(count), int(of)) == (swings.sum(), len(part))
    names = set()
    for sentence in re.split(r"(?<=\.) (?=[a-z ]+ hunts)", rest) if rest else []:
        name, at, largest, quiet = re.fullmatch(
            r"([a-z ]+) hunts at ([\d., ]+) rpm, up to ([\d.]+) mm peak to peak(?:; not at ([\d., ]+))?\.", sentence
        ).groups()
        own = part[part["controller"] == name.replace(" ", "_")]
        bad = own[swings.loc[own.index]]
        assert {float(text) for text in at.split(", ")} == set(bad["rpm"])
        assert {float(text) for text in quiet.split(", ")} == set(own["rpm"]) - set(bad["rpm"])
        assert same(largest, 1e3 * bad["limit_cycle_amplitude_m"].max())
        names.add(name)
    assert names == {name.replace("_", " ") for name in part.loc[swings, "controller"]}


def test_the_matrix_says_what_the_cells_say(page: tuple[list[str], Rows]) -> None:
    lines, rows = page
    for cell in rows.cells():
        start = lines.index(f"## {cell.machine}")
        heads = [text.strip() for text in lines[start + 2].strip("|").split("|")]
        row = next(line for line in lines[start:] if line.startswith(f"| {cell.scenario} |"))
        field = [text.strip() for text in row.strip("|").split("|")][heads.index(cell.reference)]
        word, margin, *price = field.split("<br>")
        assert word == f"**{rows.kind(cell)}**"
        if "rests on who hunts rarely" in margin:
            assert margin.startswith(" or ".join(rows.both_ways(cell)) + ": ")
            continue
        name, rpm, real, mean, *_ = re.match(rf"{CANDIDATE}: {NUMBER} mm", margin).groups()
        candidate = Reader(rows, cell).who(name, rpm, real)
        assert same(mean, 1e3 * rows.errors(rows.fresh, cell, *candidate).mean())
        if not price:
            assert rows.kind(cell) == "nothing needed"
            continue
        kind = "both" if rows.kind(cell) == "both" else "avoid"
        turning = rows.of(rows.fresh, cell, *rows.stands(cell)[kind])
        form = (
            rf"rotating: {WATTS} at the terminals(?:, ([\d.]+) N m rms of a nominal 8)?, {WATTS} paid"
            rf"(?: \(at rest {WATTS}\))?"
        )
        motor, mk, torque, paid, pk, rest, rk = re.fullmatch(form, price[0]).groups()
        still = rows.of(rows.fresh, cell, *rows.stands(cell)["compensate"])
        assert same(rest, still["paid_power_W"].mean() / (1e3 if rk else 1.0), 2)
        assert (torque is not None) == (turning["motor_torque_rms_N_m"].mean() > 8.0)
        assert torque is None or same(torque, turning["motor_torque_rms_N_m"].mean(), 2)
        assert same(motor, turning["motor_electric_power_W"].mean() / (1e3 if mk else 1.0), 2)
        assert same(paid, turning["paid_power_W"].mean() / (1e3 if pk else 1.0), 2)


def test_every_sentence_above_the_details(page: tuple[list[str], Rows]) -> None:
    lines, rows = page
    forms: dict[str, Callable[..., None]] = {
        r"Between (\w+) and (\w+) (\d+) of (\d+) verdicts differ: (.*)\.": _between,
        r"What the friction around the rod makes of the price of turning it .*, on (\w+) and on (\w+): (.*)\.": _around,
        r"What a friction model is worth at rest: .* beats the best with one in (\d+) of (\d+) cells that have both, "
        r"is level in (\d+), loses in (\d+), cannot be told in (\d+)\.": _model,
        r"Rotating does not change what the pump pays \(.*: sine ([+-][\d.]+) %, steps ([+-][\d.]+) %\)\.": _pump,
        r"On (\w+) the mean real speed is more than 2 % off the command in (\d+) of (\d+) turning cases \(furthest "
        r"([+-][\d.]+) %\); the contact is below the Stribeck speed for ([\d.]+) % of their time\.": _speed,
        r"On (\w+) the motor needs up to \(N m rms at rpm\) (.*): (above|not above) its nominal 8 N m(?: at (.*) "
        r"rpm)?; (\d+) of (\d+) turning cases are torque-limited\.": _motor,
    }
    tried = set()
    for line in section(lines, "In words"):
        form, match = next(((form, m) for form in forms if (m := re.fullmatch(form, line))), ("", None))
        assert match, f"no derivation of: {line}"
        forms[form](rows, *match.groups())
        tried.add(form)
    assert tried == set(forms)


def test_the_answer_stands_above_everything(page: tuple[list[str], Rows]) -> None:
    lines, rows = page
    answer = [
        line[2:]
        for line in lines[: next(i for i, line in enumerate(lines) if line.startswith("## "))]
        if line.startswith("- ")
    ]
    machines = []
    for line in answer:
        machine, count, told, rest = re.fullmatch(
            r"On (\w+), of (\d+) cells: ([^.]*)\.(?: Not within 0\.001 mm, and nothing helps: (.*)\.)?", line
        ).groups()
        open_ = [
            f"{cell.scenario} {cell.reference}"
            for cell in rows.cells()
            if cell.machine == machine
            and rows.kind(cell) == "nothing needed"
            and interval(rows.errors(rows.fresh, cell, *rows.stands(cell)["nothing"]))[1] > 1e-6
        ]
        assert open_ == (rest.split(", ") if rest else [])
        _by_machine(rows, machine, count, told)
        machines.append(machine)
    assert machines == ["simulated", "rig"]


def _by_machine(rows: Rows, machine: str, count: str, told: str) -> None:
    kinds = {cell: rows.kind(cell) for cell in rows.cells() if cell.machine == machine}
    assert int(count) == len(kinds)
    seen = 0
    for kind, number, names in re.findall(r"([a-z ]+) in (\d+) \(([^)]*)\)", told):
        own = [f"{cell.scenario} {cell.reference}" for cell, named in kinds.items() if named == kind.strip()]
        assert (int(number), names.split(", ")) == (len(own), own)
        seen += len(own)
    assert seen == len(kinds)


def _between(rows: Rows, here: str, there: str, count: str, of: str, told: str) -> None:
    pairs = {
        f"{cell.scenario} {cell.reference}": (rows.kind(cell), rows.kind(cell._replace(machine=there)))
        for cell in rows.cells()
        if cell.machine == here
    }
    apart = {name: pair for name, pair in pairs.items() if pair[0] != pair[1]}
    assert (int(count), int(of)) == (len(apart), len(pairs))
    assert told.split("; ") == [f"{name} ({first}, {second})" for name, (first, second) in apart.items()]


def _around(rows: Rows, first: str, second: str, told: str) -> None:
    number = re.compile(
        rf"([\d.]+) rpm: {WATTS} and {WATTS} at the rod \(ratio ([\d.]+)\), {WATTS} and {WATTS} at the terminals"
    )
    speeds = []
    for part in told.split("; "):
        rpm, a, ak, b, bk, ratio, c, ck, d, dk = number.fullmatch(part).groups()
        here = rows.search[rows.search["rpm"] == float(rpm)].groupby("machine")
        rod, terminals = here["rotation_power_W"].mean(), here["motor_electric_power_W"].mean()
        for text, kilo, value in (
            (a, ak, rod[first]),
            (b, bk, rod[second]),
            (c, ck, terminals[first]),
            (d, dk, terminals[second]),
        ):
            assert same(text, value / (1e3 if kilo else 1.0), 2)
        assert same(ratio, rod[first] / rod[second], 2)
        speeds.append(float(rpm))
    assert speeds == sorted(set(rows.search.loc[rows.search["rpm"] > 0, "rpm"]))


def _model(rows: Rows, beats: str, of: str, level: str, loses: str, untold: str) -> None:
    words = []
    for cell in rows.cells():
        held = [each for each in rows.ranked(cell, "compensate") if not rows.hunts(rows.fresh, cell, *each)]
        pressure = [each for each in held if each[0] in PRESSURE]
        model = [each for each in held if each[0] not in PRESSURE]
        if pressure and model:
            words.append(rows.word(cell, pressure[0], model[0], 1))
    counted = [words.count(word) for word in ("beats", "is level with", "loses to", "cannot be told from")]
    assert [int(text) for text in (beats, level, loses, untold)] == counted
    assert int(of) == len(words)


def _pump(rows: Rows, *told: str) -> None:
    place, draw = ["machine", "scenario", "controller"], ["reference", "draw"]
    bad = rows.search[rows.search["limit_cycle"].isin(["sustained", "too_short"])]
    quiet = rows.search[~rows.search.set_index([*place, "rpm"]).index.isin(bad.set_index([*place, "rpm"]).index)]
    turning, rest = quiet[quiet["rpm"] > 0], quiet[quiet["rpm"] == 0]
    both = turning.merge(rest, on=[*place, *draw], suffixes=("", "_rest"))
    for reference, text in zip(("sine", "steps"), told, strict=True):
        part = both[both["reference"] == reference]
        change = part["supply_power_W"].mean() / part["supply_power_W_rest"].mean() - 1.0
        assert float(text) == pytest.approx(100.0 * change, abs=0.051)


def _speed(rows: Rows, machine: str, count: str, of: str, furthest: str, below: str) -> None:
    whole = pd.concat([rows.search, rows.fresh], ignore_index=True)
    part = whole[(whole["machine"] == machine) & (whole["rpm"] > 0)]
    off = 100.0 * (part["rotation_speed_mean_rpm"] - part["rpm"]) / part["rpm"]
    assert (int(count), int(of)) == ((off.abs() > 2.0).sum(), len(part))
    assert float(furthest) == pytest.approx(off.iloc[off.abs().argmax()], abs=0.051)
    assert float(below) == pytest.approx(100.0 * part["below_stribeck_fraction"].mean(), abs=0.051)


def _motor(rows: Rows, machine: str, told: str, limit: str, above: str | None, limited: str, of: str) -> None:
    whole = pd.concat([rows.search, rows.fresh], ignore_index=True)
    part = whole[(whole["machine"] == machine) & (whole["rpm"] > 0)]
    most = part.groupby("rpm")["motor_torque_rms_N_m"].max()
    for text in told.split(", "):
        torque, rpm = text.split(" at ")
        assert same(torque, most[float(rpm)], 2)
    assert len(told.split(", ")) == len(most)
    assert [float(rpm) for rpm in above.split(", ")] == list(most[most > 8.0].index) if above else (most <= 8.0).all()
    assert limit == ("above" if above else "not above")
    assert (int(limited), int(of)) == (part["outcome"].eq("torque-limited").sum(), len(part))


def test_what_changes_the_verdicts(page: tuple[list[str], Rows]) -> None:
    lines, rows = page
    first, second = section(lines, "What changes the verdicts")
    now = {f"{cell.machine} {cell.scenario} {cell.reference}": rows.kind(cell) for cell in rows.cells()}
    searched = Rows(rows.search, rows.search)
    then = {f"{cell.machine} {cell.scenario} {cell.reference}": searched.kind(cell) for cell in rows.cells()}
    apart = {name: (then[name], kind) for name, kind in now.items() if then[name] != kind}
    start = f"With the draws from which the best were chosen, {len(apart)} of {len(now)} verdicts would be others"
    told = "; ".join(f"{name} ({old} in place of {new})" for name, (old, new) in apart.items())
    assert second == (f"{start}: {told}." if apart else f"{start}.")
    assert re.match(
        rf"With draw 1 alone in place of all of the choice, taken at its word, \d+ of {len(now)} verdicts would be "
        "others",
        first,
    )
    for name, new in re.findall(r"(\w+ \w+ \w+) \([a-z ]+ in place of ([a-z ]+)\)", first):
        assert then[name] == new


def test_what_was_run_and_how_it_is_judged(page: tuple[list[str], Rows], tmp_path: Path) -> None:
    lines, rows = page
    search, fresh = rows.search, rows.fresh
    scope = next(line for line in lines if line.startswith(f"{len(search)} cases"))
    assert scope == (
        f"{len(search)} cases: 2 machines, 5 controllers, 3 speeds of rotation, 2 scenarios, 2 motions, 10 "
        f"draws. All completed. Measured again: {len(fresh)} cases on 16 fresh draws."
    )
    rules = " ".join(section(lines, "How it is judged"))
    for words in ("5 % of the larger and 0.001 mm", "the 6 comparisons", "95 % (Bonferroni)", "rest on fresh draws"):
        assert words in rules
    told = f"Of {len(search)} cases whose solver error was found, 0 have one above 10 % of their error; in 0 of these"
    assert told in rules
    assert section(lines, "Left out") == ["Ramps."]
