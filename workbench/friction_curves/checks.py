"""[friction_curves] of a study, checked before anything runs: its files are read, and hold what it asks for."""

from collections.abc import Iterable, Sequence

from workbench.errors import UserError
from workbench.friction_curves.measured import FASTEST, Curve, read_curves, without_rotation
from workbench.friction_curves.schema import FrictionCurvesTable
from workbench.parameters.sets import parameter_path, read_parameters
from workbench.records.friction import SLIDING
from workbench.study.sections import Checked
from workbench.study.study import Study
from workbench.toml.reading import Key

TABLE = "friction_curves"


def check_friction_curves(spec: FrictionCurvesTable, checked: Checked) -> None:
    """Raise UserError for the first mistake of [friction_curves], and of the panels that draw measured friction."""
    study = checked.study
    rpm = sorted({curve.rpm for curve in curves_of(study, spec)})
    for i, figure in enumerate(study.file.figures):
        for j, panel in enumerate(figure.panels):
            if panel.measured_rpm is not None:
                _is_there(study, spec, ("figures", i, "panels", j, "measured_rpm"), [panel.measured_rpm], rpm)
    turning = [value for value in rpm if value]
    for name, asked in {"fit_rpm": spec.fit_rpm, "check_rpm": spec.check_rpm}.items():
        _is_there(study, spec, (TABLE, name), asked, turning)
        if twice := [value for i, value in enumerate(asked) if value in asked[:i]]:
            raise study.error((TABLE, name), f"holds {twice[0]:g} rpm twice: expected each once")
    if both := [value for value in spec.check_rpm if value in spec.fit_rpm]:
        message = f"{both[0]:g} rpm is in fit_rpm too: expected speeds that the fit does not see; take it out of one"
        raise study.error((TABLE, "check_rpm"), message)
    for name in spec.reference_slope:
        _is_there(study, spec, (TABLE, "reference_slope"), [_number(study, name)], turning)
    if not SLIDING <= spec.speed <= FASTEST:
        message = f"got {spec.speed:g} m/s, expected one that was measured: {SLIDING:g} to {FASTEST:g} m/s"
        raise study.error((TABLE, "speed"), message)


def curves_of(study: Study, spec: FrictionCurvesTable) -> list[Curve]:
    """The measured curves of a study with those without rotation.

    Raises:
        UserError: a file is missing or does not serve.
    """
    folder = study.path.parent
    try:
        at_rest = without_rotation(read_parameters(parameter_path(spec.parameters, folder)))
    except UserError as error:
        raise study.error((TABLE, "parameters"), str(error)) from None
    path = folder / spec.measured
    if not path.is_file():
        message = f'got "{spec.measured}", no such file beside the study: expected one of measured static parameters'
        raise study.error((TABLE, "measured"), message)
    return [*at_rest, *read_curves(path)]


def _is_there(
    study: Study, spec: FrictionCurvesTable, key: Key, asked: Iterable[float], known: Sequence[float]
) -> None:
    for value in asked:
        if value not in known:
            there = ", ".join(f"{one:g}" for one in known)
            raise study.error(key, f"no {value:g} rpm in {spec.measured}; there are {there}")


def _number(study: Study, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        message = f'got "{text}", expected a speed of rotation in rpm, such as 75'
        raise study.error((TABLE, "reference_slope"), message) from None
