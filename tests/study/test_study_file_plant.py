"""Study files with a mistake in their plant, its parameters, or what is believed of them."""

from pathlib import Path

import pytest
from command import DRIVE, STUDY, changed, write
from mistakes import expect, said

MISTAKES = {
    "unknown key": (changed("model =", "modl ="), '@:3: plant.modl: unknown key; did you mean "model"?'),
    "missing key": (changed('model = "by_rpm"\n', ""), "@:2: plant.model: is missing; this key is needed here"),
    "wrong unit": (
        STUDY + '[plant.set]\nsupply_pressure = "2.94 kg"\n',
        '@:22: plant.set.supply_pressure: got "2.94 kg", expected a quantity in Pa, such as "1 Pa"',
    ),
    "negative mass": (
        STUDY + '[plant.set]\nmass = "-34 kg"\n',
        "@:22: plant.set.mass: got -34 kg, expected a value that is not negative",
    ),
    "unknown parameter": (
        STUDY + '[plant.set]\nsuply_pressure = "2.94 MPa"\n',
        '@:22: plant.set.suply_pressure: unknown parameter "suply_pressure"; did you mean "supply_pressure"?',
    ),
    "truth value": (
        STUDY + "[plant.set]\ncoulomb = true\n",
        "@:22: plant.set.coulomb: got True: input should be a valid number",
    ),
    "scale of nothing": (
        STUDY + "[plant.scale]\nviscos = 2\n",
        '@:22: plant.scale.viscos: unknown parameter; did you mean "viscous"?',
    ),
    "negative scale": (
        STUDY + "[plant.scale]\nviscous = -2.0\n",
        "@:22: plant.scale.viscous: got -2.0, expected a factor that is not negative",
    ),
    "belief": (
        STUDY + '[belief.set]\nmas = "1 kg"\n',
        '@:22: belief.set.mas: unknown parameter "mas"; did you mean "mass"?',
    ),
    "unknown friction law": (
        changed('"by_rpm"', '"non_rotating"\nfriction = "lugree"').replace("rpm = [", "# rpm = ["),
        '@:4: plant.friction: unknown friction law "lugree"; did you mean "lugre"?',
    ),
    "law of a rod that turns": (
        changed('"by_rpm"', '"by_rpm"\nfriction = "gms"'),
        '@:4: plant.friction: friction "gms" has no form for a turning rod with bristle "helical"; expected a rod '
        "that does not rotate, or another law",
    ),
    "parameter that a law has no place for": (
        changed('"drive"', '"drive"\nfriction = "coulomb"\nset.bristle_damping = 1', DRIVE),
        '@:5: plant.set.bristle_damping: plant "drive_force_coulomb" has no use for it; did you mean '
        '"end_stop_damping"?',
    ),
    "belief in an unknown law": (
        STUDY + '[belief]\nfriction = "gsm"\n',
        '@:22: belief.friction: unknown friction law "gsm"; did you mean "gms"?',
    ),
    "unknown plant": (changed("by_rpm", "by_rmp"), '@:3: plant.model: unknown plant "by_rmp"; did you mean "by_rpm"?'),
    "unknown set": (
        changed("owen2001_simulation", "owen2001_simulaton"),
        '@:4: plant.parameters: unknown parameter set "owen2001_simulaton"; did you mean "owen2001_simulation"? '
        "(a file needs the ending .toml)",
    ),
    "set that lacks values": (
        changed("owen2001_simulation", "canudas1995"),
        '@:4: plant.parameters: "canudas1995" does not serve non_rotating: the parameter set lacks ',
    ),
    "NaN parameter": (
        STUDY + "[plant.set]\nmass = nan\n",
        "@:22: plant.set.mass: got nan: input should be a finite number",
    ),
    "valve of a drive": (
        changed('"drive"', '"drive"\nflow = "chapter3"', DRIVE),
        '@:4: plant.flow: plant "drive_force" has no use for it; leave it out',
    ),
    "hose of a drive": (
        DRIVE + "[plant.set]\nbristle_stifness = 1\n",
        '@:18: plant.set.bristle_stifness: unknown parameter "bristle_stifness"; did you mean "bristle_stiffness"?',
    ),
    "parameter without use": (
        DRIVE + '[plant.set]\nvalve_time_constant = "12 ms"\n',
        '@:18: plant.set.valve_time_constant: plant "drive_force" has no use for it; expected one of ',
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_line(tmp_path: Path, mistake: str) -> None:
    expect(tmp_path, *MISTAKES[mistake])


def test_a_parameter_file_of_a_study(tmp_path: Path) -> None:
    """A mistake in a file that the study names is located in both."""
    write(tmp_path, 'title = "a"\nsource = "b"\n[parameters.mass]\nvalue = "1 m"\nsource = "c"\n', "mine.toml")
    found = said(tmp_path, changed("owen2001_simulation", "mine.toml"))
    place = f"@:4: plant.parameters: {tmp_path / 'mine.toml'}:4: parameters.mass.value: "
    assert found == f'{place}got "1 m", expected a quantity in kg, such as "1 kg"'
