"""The whole diagnosis of an experiment: records, residual stage, simulation stage, held-out records."""

from collections.abc import Sequence
from pathlib import Path

from workbench.diagnose.before_after import errors_of
from workbench.diagnose.effects import effects_of_both, effects_of_result, fitted_parameters, misled, sensor_offset
from workbench.diagnose.readiness import check_experiment, declared_values, motions_of
from workbench.diagnose.residual_stage import (
    ResidualStage,
    baselines,
    with_declared_of,
    with_effects,
    with_effects_of,
    with_floors,
    with_most,
    with_simulated_floors,
)
from workbench.diagnose.residuals.balances import richest
from workbench.diagnose.residuals.fit import NEAR_NOISE
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.result import Diagnosis, FoundEffect
from workbench.diagnose.selection.unexplained import strongest, unexplained_of
from workbench.diagnose.simulation.by_curve import Curved, curved
from workbench.diagnose.simulation.fits import Simulated
from workbench.diagnose.simulation.held_out import without_refuted
from workbench.diagnose.simulation.reached import (
    SimulationStart,
    farther_baseline,
    given_by,
    nearer_baseline,
    nearer_with,
    simulated_baseline,
    simulated_with,
)
from workbench.diagnose.simulation.setup import as_simulated
from workbench.diagnose.simulation.stage import SimulationStage, simulation_stage
from workbench.progress import Progress, of_unknown_length, silent
from workbench.records.experiment import Experiment, read_experiment
from workbench.records.reading import read_records


def diagnose(path: Path, progress: Progress = silent) -> Diagnosis:
    """Diagnose an experiment file; `progress` is told what is being done, and how far it is.

    Raises:
        UserError: the file or a record cannot be used, or its channels allow no balance.
    """
    experiment = read_experiment(path)
    progress("reading records", 0.0)
    check_experiment(experiment)
    records = read_records(experiment, "fit")
    both = motions_of(experiment, [*records, *read_records(experiment, "held_out")])
    motions, held_out = both[: len(records)], both[len(records) :]
    declared = declared_values(experiment)
    offset = sensor_offset(motions, declared)
    sensor = [offset] if offset is not None else []
    plain = stage = baselines(experiment, motions, declared, offset, progress)
    base = simulated_baseline(experiment, as_simulated(experiment, motions), plain.simulation_start(sensor), progress)
    searching = progress
    if base is None or base.fit.excess > NEAR_NOISE:
        searching = of_unknown_length(progress)
        stage = with_effects(with_floors(plain, experiment, searching), experiment, searching)
    simulation = None
    if base is not None:
        stage, start, found = _simulated(experiment, base, plain, stage, sensor, searching)
        simulation = without_refuted(experiment, found, held_out, start)
    return _diagnosis(experiment, held_out, declared, _effects_of(stage, sensor), stage, simulation, progress)


def _simulated(
    experiment: Experiment,
    base: Simulated,
    plain: ResidualStage,
    stage: ResidualStage,
    sensor: Sequence[FoundEffect],
    progress: Progress,
) -> tuple[ResidualStage, SimulationStart, SimulationStage]:
    """What the simulated plant lacks, and the balances that were its guide at last: `stage` with its effects, or with
    some of them, or where they stand far from noise and the plant alone does not, `plain`.
    """

    def begun(base: Simulated, stage: ResidualStage) -> tuple[SimulationStart, Simulated | None]:
        start = stage.simulation_start(_effects_of(stage, sensor))
        return start, simulated_with(experiment, base, start, progress)

    start, them = begun(base, stage)
    curve: Curved | None = None
    if base.fit.excess > NEAR_NOISE and _is_far(them):
        if not base.is_near:
            given = given_by(base, start)
            base, them, curve = curved(experiment, base, them, stage.curves, given, start, progress)
        if curve is None and base.fit.excess > NEAR_NOISE and _is_far(them):
            base = farther_baseline(experiment, base, start, progress)
        if curve is None and not base.is_near and _is_far(them):
            base = nearer_baseline(experiment, base, start, progress)
        if base.fit.excess < NEAR_NOISE:  # what balances far from noise show is no guide
            stage = plain
            start, them = begun(base, stage)
    if curve is None and them is not None and them.fit.excess > NEAR_NOISE:
        them = nearer_with(experiment, base, them, start, progress)
        most = with_most(stage) if _is_far(them) else stage
        if most is not stage:
            stage = most
            start, them = begun(base, stage)
    return stage, start, simulation_stage(experiment, start, base, them, curve, progress)


def _effects_of(stage: ResidualStage, sensor: Sequence[FoundEffect]) -> list[FoundEffect]:
    """Those of a sensor, and of the balances."""
    return [*sensor, *(effect for result in stage.results for effect in effects_of_result(result))]


def _is_far(them: Simulated | None) -> bool:
    """Whether no plant with effects is near to noise."""
    return them is None or them.fit.excess > NEAR_NOISE


def _diagnosis(
    experiment: Experiment,
    held_out: Sequence[Motion],
    declared: Values,
    effects: Sequence[FoundEffect],
    stage: ResidualStage,
    simulation: SimulationStage | None,
    progress: Progress,
) -> Diagnosis:
    """What both stages say together: `effects` are those of the residual stage, and of a sensor."""
    if simulation is not None:
        if simulation.is_trusted:
            stage = with_declared_of(stage, experiment, simulation)
        if simulation.curved is None:  # else they are those of the balances
            stage = with_effects_of(stage, experiment, effects, simulation)
        effects = effects_of_both(effects, simulation)
        if simulation.is_near and simulation.lacks is None:
            stage = with_simulated_floors(stage, simulation, experiment.bounds)
    before, fits = [result.before for result in stage.results], [result.after for result in stage.results]
    if simulation is not None and simulation.baseline_is_trusted:  # its parameters count before those of the balances
        before.append(simulation.before)
    if simulation is not None and simulation.is_trusted:
        fits.append(simulation.after)
    unexplained = None
    by_curve = simulation.curved if simulation is not None else None
    left = simulation.lacks if simulation is not None else None
    if left is None and (simulation is None or not simulation.is_near):
        left = strongest(stage.dependences)
    after = next((result.after for result in stage.results if left and result.balance.name == left.balance), None)
    if by_curve is not None and after is not None:
        unexplained = by_curve.unexplained(after, held_out)
        fits.append(by_curve.own)
    elif left is not None and after is not None:
        unexplained = unexplained_of(after, left, held_out, richest(experiment.plant))
    final = fitted_parameters(fits, lacks=unexplained is not None)
    progress("held-out records", 0.9)
    return Diagnosis(
        experiment=experiment,
        held_out=held_out,
        results=stage.results,
        simulation=simulation,
        effects=effects,
        unexplained=unexplained,
        errors=errors_of(experiment, stage.results, simulation, stage.baseline, stage.corrected, held_out),
        declared=declared,
        baseline=stage.baseline,
        corrected=stage.corrected,
        baseline_parameters=misled(fitted_parameters(before), final) if effects else fitted_parameters(before),
        fitted_parameters=final,
    )
