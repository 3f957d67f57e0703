"""What a stranger adds, kind by kind, by an entry point alone: it is listed, checked, run and reported like ours."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import DRIVE, changed, fails, ran, workbench, write

from workbench.records.tables import read_table

MODULE = """\
import json
from dataclasses import dataclass
from pathlib import Path
import numpy as np
import pandas as pd
from plants.equation import equation
from plants.friction import directed
from plants.laws.interface import FrictionLaw, Nothing
from workbench.metrics.interface import Column, Metric
from workbench.publish.tables import Table, write_frame
from workbench.records.formats.interface import RecordFormat
from workbench.simulation.integrators.interface import IntegrationMethod
from workbench.simulation.references import Moving
from workbench.study.reference_tables import Kind, ReferenceTable, quantity
from workbench.study.sections import Section
from workbench.study.study import check_name
from workbench.toml.quantities import Raw, Second
from workbench.toml.reading import Strict

@equation
def friction(velocity, contact, held, p):
    return steady(velocity, p), Nothing()
@equation
def steady(velocity, p):
    own = directed(velocity, velocity, p.friction)
    return own.coulomb * np.arctan(velocity / own.stribeck_velocity) + own.viscous * velocity
LAW = FrictionLaw("arctan", "an arc tangent of the speed", "a test", friction, steady,
                  uses=("coulomb", "viscous", "stribeck_velocity"))

def variation(observed):
    command, time = observed.run.command[observed.window.samples], observed.run.time[observed.window.samples]
    return {"command_rate_V_per_s": float(np.mean(np.abs(np.diff(command))) / (time[1] - time[0]))}
METRIC = Metric("rate", (Column("command_rate_V_per_s", "V/s", "mean rate of the command"),), variation)
BAD = Metric("bad", (Column("command_rate", "V/s", "mean rate of the command"),), variation)

@dataclass(frozen=True)
class Ease(Moving):
    height: float
    rise: float
    def __call__(self, time):
        share, w = np.clip(time / self.rise, 0.0, 1.0), np.pi / self.rise
        moving = time < self.rise
        return (0.5 * self.height * (1.0 - np.cos(np.pi * share)),
                np.where(moving, 0.5 * self.height * w * np.sin(np.pi * share), 0.0),
                np.where(moving, 0.5 * self.height * w * w * np.cos(np.pi * share), 0.0))
class EaseTable(ReferenceTable):
    height: Raw
    rise: Second
    def build(self, unit, folder):
        return Ease(quantity(self, "height", unit), self.rise)
REFERENCE = Kind("ease", EaseTable)

FORMAT = RecordFormat("lines", "a JSON object a sample", (".jsonl",), lambda path: pd.read_json(path, lines=True))

RALSTON = IntegrationMethod("ralston", "fixed step, order 2", "Ralston 1962", (2 / 3,), ((2 / 3,),), (1 / 4, 3 / 4))

class Best(Strict):
    name: str
    result: str
def check(table, checked):
    check_name(checked.study, (*checked.key, "result"), "figure", table.result, checked.figures)
def tables(table, study, frame, folder):
    best = frame.loc[[frame[table.result].idxmin()], ["rpm", table.result]].astype(str)
    return [write_frame(table.name, Table("the best", best, []), folder / "tables")[1]]
SECTION = Section(name="best", table=Best, several=True, check=check, tables=tables)
"""

POINTS = {
    "friction_laws": "arctan = stranger:LAW",
    "metrics": "rate = stranger:METRIC\nbad = stranger:BAD",
    "references": "ease = stranger:REFERENCE",
    "formats": "lines = stranger:FORMAT",
    "integrators": "ralston = stranger:RALSTON",
    "sections": "best = stranger:SECTION",
}

EASED = changed(
    'kind = "sine"\namplitude = "5 mm"\nfrequency = "2 Hz"', 'kind = "ease"\nheight = "5 mm"\nrise = "0.5 s"'
)


@pytest.fixture(autouse=True)
def _installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The module, as an installer leaves it."""
    site = tmp_path / "site"
    information = site / "stranger-1.0.dist-info"
    information.mkdir(parents=True)
    write(site, MODULE, "stranger.py")
    write(information, "Metadata-Version: 2.1\nName: stranger\nVersion: 1.0\n", "METADATA")
    groups = "".join(f"[friction_workbench.{group}]\n{lines}\n" for group, lines in POINTS.items())
    write(information, groups, "entry_points.txt")
    monkeypatch.setattr(sys, "path", [str(site), *sys.path])
    monkeypatch.delitem(sys.modules, "stranger", raising=False)


@pytest.mark.parametrize(
    ("kind", "line"),
    [
        ("friction_laws", "arctan an arc tangent of the speed; turning rods: none"),
        ("references", "ease height, rise"),
        ("integrators", "ralston fixed step, order 2"),
        ("formats", "lines .jsonl: a JSON object a sample"),
        ("columns", "command_rate_V_per_s V/s mean rate of the command"),
    ],
)
def test_it_is_listed(kind: str, line: str) -> None:
    assert line in [" ".join(shown.split()) for shown in workbench("list", kind).out.splitlines()]


def test_a_metric_whose_name_lacks_its_unit_is_told() -> None:
    assert 'column "command_rate": expected a name that ends in its unit, _V_per_s' in workbench("list", "columns").out


def test_reference_metric_and_table_in_one_study(tmp_path: Path) -> None:
    """The metric has its unit in tables: shown in V/ms it is a thousandth; the new kind of table is written."""
    table = '[[tables]]\nname = "t"\ntitle = "t"\nindex = "rpm"\ncolumns = [{ result = "command_rate_V_per_s", '
    text = EASED + table + 'label = "rate", unit = "V/ms" }]\n[[best]]\nname = "least"\nresult = "rms_error_m"\n'
    assert workbench("check", write(tmp_path, text)).code == 0
    out = ran(tmp_path, text)
    results = pd.read_csv(out / "results.csv")
    shown = pd.read_csv(out / "tables" / "t.csv")
    assert results["command_rate_V_per_s"].gt(0.0).all()
    np.testing.assert_allclose(shown["rate (V/ms)"], 1e-3 * results["command_rate_V_per_s"], rtol=1e-3)
    assert (out / "tables" / "least.csv").exists()
    wrong = changed('"rms_error_m"', '"rms_eror_m"', text)
    fails(workbench("check", write(tmp_path, wrong)), 'best.0.result: unknown figure "rms_eror_m"; did you mean')


def test_a_wrong_setting_of_its_reference_is_told(tmp_path: Path) -> None:
    fails(workbench("check", write(tmp_path, changed('"5 mm"', '"5 V"', EASED))), "references.sine.height: got")


def test_law_and_integrator_in_one_study(tmp_path: Path) -> None:
    """The integrator's order is 2: with half the step the error is a quarter."""
    text = changed(
        'model = "drive"', 'model = "drive"\nfriction = "arctan"\nset = { stribeck_velocity = "0.5 m/s" }', DRIVE
    )
    errors = []
    for number, step in enumerate(("1 ms", "0.5 ms")):
        folder = tmp_path / str(number)
        folder.mkdir()
        out = ran(folder, text + f'method = "ralston"\nstep = "{step}"\n')
        errors.append(pd.read_csv(out / "results.csv")["solver_error_m"][0])
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.2)


def test_a_record_in_its_format(tmp_path: Path) -> None:
    frame = pd.DataFrame({"t": [0.0, 0.1], "x": [1.5, 2.5]})
    frame.to_json(tmp_path / "a.jsonl", orient="records", lines=True)
    pd.testing.assert_frame_equal(read_table(tmp_path / "a.jsonl"), frame)
