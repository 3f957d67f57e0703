"""Parameter sets: those that come with the program, and every way in which a file can be wrong."""

from pathlib import Path

import pytest

from plants.equation import fields
from plants.registry import plants
from workbench.errors import UserError
from workbench.parameters.sets import build, known_units, named_sets, parameter_path, parameter_value, read_parameters
from workbench.toml.reading import read_toml
from workbench.toml.units import QuantityError

SETS = ["canudas1995", "crane_boom", "owen2001_experiment", "owen2001_simulation"]


def test_the_named_sets_are_there() -> None:
    assert list(named_sets()) == SETS


@pytest.mark.parametrize("name", SETS)
def test_every_value_has_a_source(name: str) -> None:
    path = named_sets()[name]
    data, _ = read_toml(path)
    assert data["source"].strip()
    assert set(read_parameters(path)) == set(data["parameters"]) <= set(known_units())
    for entry in data["parameters"].values():
        assert len(entry["source"].strip()) >= 7
        assert isinstance(entry["value"], str), "values are written with their unit"


@pytest.mark.parametrize(
    ("name", "parameter", "value"),
    [
        ("owen2001_simulation", "supply_pressure", 2.94e6),
        ("owen2001_simulation", "valve_position_gain", 0.6e-3 / 10.0),
        ("owen2001_simulation", "piston_radius", 0.019),
        ("owen2001_simulation", "bristle_stiffness", 5.77e6),
        ("owen2001_experiment", "supply_pressure", 4.91e6),
        ("owen2001_experiment", "coulomb_negative", 290.0),
        ("owen2001_experiment", "stribeck_velocity", 2.4e-3),
        ("owen2001_experiment", "bristle_damping_negative", 11.3e4),
        ("canudas1995", "bristle_damping", 1e5**0.5),
        ("canudas1995", "stribeck_velocity", 1e-3),
    ],
)
def test_published_values(name: str, parameter: str, value: float) -> None:
    assert read_parameters(named_sets()[name])[parameter] == pytest.approx(value, rel=1e-12)


def test_damping_rule_of_the_thesis_holds_for_the_corrected_stiffness() -> None:
    """Thesis (4.14): sigma1 + a2 = 2 * 0.9 sqrt(sigma0 M)."""
    p = read_parameters(named_sets()["owen2001_simulation"])
    rule = 1.8 * (p["bristle_stiffness"] * p["mass"]) ** 0.5
    assert p["bristle_damping"] + p["viscous"] == pytest.approx(rule, rel=0.005)


@pytest.mark.parametrize("name", SETS)
def test_every_set_builds_the_plants_that_it_is_meant_for(name: str) -> None:
    values = read_parameters(named_sets()[name])
    built = set()
    for plant in plants().values():
        try:
            parameters = build(plant.Parameters, values)
        except UserError as error:
            assert "the parameter set lacks" in str(error)  # noqa: PT017  which plants these are is asserted below
        else:
            built.add(plant.name)
            assert plant.command_limit(parameters) > 0.0
    rotating = {f"rotating_{law}{kind}" for law in ("helical", "isotropic", "anisotropic") for kind in ("", "_ideal")}
    hydraulic = {"drive_force", "non_rotating", "two_chamber"}
    others = {"canudas1995": {"drive_force"}, "crane_boom": {"valve_axis"}}
    assert built == others.get(name, hydraulic | rotating)


def test_a_negative_value_that_is_not_given_is_the_positive_one() -> None:
    cls = plants()["non_rotating"].Parameters
    one = build(cls, read_parameters(named_sets()["owen2001_simulation"])).friction
    assert one.negative == one.positive
    two = build(cls, read_parameters(named_sets()["owen2001_experiment"])).friction
    assert (two.positive.coulomb, two.negative.coulomb) == (330.0, 290.0)


def test_flow_law_by_name() -> None:
    cls, values = plants()["non_rotating"].Parameters, read_parameters(named_sets()["owen2001_simulation"])
    assert build(cls, values).hydraulics.flow_pressure_share == 0.5
    assert build(cls, values, "chapter3").hydraulics.flow_pressure_share == 1.0


def test_missing_parameters_are_named() -> None:
    values = dict(read_parameters(named_sets()["owen2001_simulation"]))
    del values["mass"], values["bulk_modulus"]
    with pytest.raises(UserError, match="the parameter set lacks bulk_modulus, mass"):
        build(plants()["non_rotating"].Parameters, values)


def test_unequal_areas_are_refused() -> None:
    values = {**read_parameters(named_sets()["owen2001_simulation"]), "piston_area_2": 5e-4}
    with pytest.raises(UserError, match=r"piston areas 0\.000633 and 0\.0005 m\^2 differ"):
        build(plants()["non_rotating"].Parameters, values)


def test_a_bristle_needs_a_friction_level() -> None:
    values = {**read_parameters(named_sets()["canudas1995"]), "coulomb": 0.0, "stribeck": 0.0}
    with pytest.raises(UserError, match="coulomb and stribeck are both 0"):
        build(plants()["drive_force"].Parameters, values)
    assert build(plants()["drive_force"].Parameters, {**values, "bristle_stiffness": 0.0}).body.mass == 1.0


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("mass", "-34 kg", "got -34 kg, expected a value that is not negative"),
        ("mass", "0 kg", "got 0 kg, expected a value above 0"),
        ("coulomb_negative", "-1 N", "got -1 N, expected a value that is not negative"),
        ("bulk_modulus", "inf", "got inf, expected a finite value"),
        ("load_force", float("-inf"), "got -inf, expected a finite value"),
        ("mas", 1.0, 'unknown parameter "mas"; did you mean "mass"?'),
        ("flow_pressure_share", 0.5, 'unknown parameter "flow_pressure_share"'),
    ],
)
def test_impossible_values(name: str, value: float | str, said: str) -> None:
    with pytest.raises((UserError, QuantityError)) as caught:
        parameter_value(name, value)
    assert said in str(caught.value)


def test_possible_values() -> None:
    assert parameter_value("load_force", "-120 N") == -120.0
    assert parameter_value("coulomb", "0 N") == 0.0
    assert parameter_value("stroke", "inf") == float("inf")
    with pytest.raises(QuantityError, match="expected a quantity in Pa"):
        parameter_value("supply_pressure", "2.94 kg")


HEAD = 'title = "a"\nsource = "b"\n'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            HEAD + '[parameters.supply_pressure]\nvalue = "2.94 kg"\nsource = "c"\n',
            ':4: parameters.supply_pressure.value: got "2.94 kg", expected a quantity in Pa, such as "1 Pa"',
        ),
        (
            HEAD + '[parameters.mass]\nsource = "c"\nvalue = nan\n',
            ":5: parameters.mass.value: got NaN, expected a quantity in kg",
        ),
        (
            HEAD + '[parameters.mass]\nvalue = "-34 kg"\nsource = "c"\n',
            ":4: parameters.mass.value: got -34 kg, expected a value that is not negative",
        ),
        (
            HEAD + '[parameters.coulom]\nvalue = "1 N"\nsource = "c"\n',
            ':4: parameters.coulom.value: unknown parameter "coulom"; did you mean "coulomb"?',
        ),
        (
            HEAD + 'parameters.mass = { value = "34 kg" }\n',
            ":3: parameters.mass.source: is missing; this key is needed here",
        ),
        (
            HEAD + '[parameters.mass]\nvalue = "34 kg"\nsource = "c"\nstd = "1 m"\n',
            'got "1 m", expected a quantity in kg',
        ),
        (
            HEAD + '[parameters.mass]\nvalue = "34 kg"\nsource = "c"\nsorce = "d"\n',
            ':6: parameters.mass.sorce: unknown key; did you mean "source"?',
        ),
        (HEAD + "[parameters]\n", ":3: parameters: "),
        (HEAD + "[parameters.mass\n", "not a TOML file"),
        (HEAD, ": parameters: is missing; this key is needed here"),
    ],
)
def test_wrong_files(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "plant.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises((UserError, QuantityError)) as caught:
        read_parameters(path)
    assert str(caught.value).startswith(str(path))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_parameter_path(tmp_path: Path) -> None:
    assert parameter_path("canudas1995", tmp_path) == named_sets()["canudas1995"]
    assert parameter_path("mine.toml", tmp_path) == tmp_path / "mine.toml"
    with pytest.raises(UserError, match='unknown parameter set "canudas95"; did you mean "canudas1995"'):
        parameter_path("canudas95", tmp_path)


def test_units_of_one_name_agree_between_plants() -> None:
    """A name means one thing: the same unit in every plant that has it."""
    for plant in plants().values():
        for item in fields(plant.Parameters):
            assert known_units()[item.name] == item.unit, (plant.name, item.name)
