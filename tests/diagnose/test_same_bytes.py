"""Each process orders its sets by strings in its own way: no number may depend on that."""

import random
from collections.abc import Callable, Collection
from functools import partial
from pathlib import Path
from typing import Any
from zlib import crc32

import pytest
from command import write
from experiments import experiment_text, make_record

from plants.interface import Plant
from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residuals import balances
from workbench.diagnose.residuals.shown import Dependences, dependences
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records


def shuffled(draw: random.Random, names: Collection[str]) -> list[str]:
    return draw.sample(sorted(names), len(names))


def ordered(how: Callable[[Any], Any]) -> Callable[[Plant], Dependences]:
    """On what rates depend, with names in this order."""

    def of(plant: Plant) -> Dependences:
        found = dependences(plant)
        tables = {
            table: {name: how(names) for name, names in getattr(found, table).items()} for table in ("states", "inputs")
        }
        return found._replace(**tables)

    return of


def test_a_floor_is_the_same_to_the_last_bit_whatever_the_order_of_a_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_record(tmp_path)
    experiment = read_experiment(write(tmp_path, experiment_text({}, ["coulomb"]), "experiment.toml"))
    motions, values = motions_of(experiment, read_records(experiment)), declared_values(experiment)
    monkeypatch.setattr(balances, "deviation", lambda *_, **__: 0.3)  # none outweighs another
    monkeypatch.setattr(balances, "_change", lambda moved, base: 1.0 + crc32(moved.tobytes()) / 2.0**32)
    found = []
    for draw in map(random.Random, range(20)):
        monkeypatch.setattr(balances, "dependences", ordered(partial(shuffled, draw)))
        made = balances.balances_of(experiment, motions, values)
        found.append({balance.name: balance.floor for balance in made})
    assert all(floors == found[0] for floors in found)
    assert {"flow", "force"} <= set(found[0])
