"""What the figures of a diagnosis show, and the series in them."""

from dataclasses import replace

import numpy as np
import pytest
from diagnoses import doubting

from workbench.diagnose.report.figures.every import pictures_of
from workbench.diagnose.report.figures.evidence import (
    LEAST_SHOWN,
    CandidateBar,
    EvidenceData,
    EvidenceRound,
    draw_evidence,
)
from workbench.diagnose.report.figures.parameters import draw_parameters, parameters_data
from workbench.diagnose.report.figures.simulation import _compared, _kept, simulation_data
from workbench.diagnose.report.series import autocorrelation, binned, parts_of, shown_signals
from workbench.diagnose.result import BeforeAfter, Diagnosis
from workbench.diagnose.simulation.free_run import SETTLED


def test_the_axis_of_parameters_is_that_of_the_values_however_wide_an_interval_is(diagnosis: Diagnosis) -> None:
    """Coulomb friction of 300 N +- 2.3 MN, once: no tick was left, and 0 looked like decades."""
    wide = doubting(diagnosis, "baseline_parameters", "coulomb", std=2.3e6)
    data, plain_data = (parameters_data(either) for either in (wide, diagnosis))
    assert data is not None
    assert plain_data is not None
    picture, plain = draw_parameters(data), draw_parameters(plain_data)
    (axes,) = picture.figure.axes
    low, high = axes.get_xlim()
    assert high - low < 10.0 * np.ptp(plain.figure.axes[0].get_xlim())
    assert sum(low <= tick <= high for tick in axes.get_xticks()) >= 2
    place = [label.get_text() for label in axes.get_yticklabels()].index("coulomb") - 0.14  # of the baseline
    assert {"<", ">"} <= {line.get_marker() for line in axes.lines if np.all(line.get_ydata() == place)}


def test_before_and_after_have_scales_of_their_own(diagnosis: Diagnosis) -> None:
    pictures = pictures_of(diagnosis)
    before, after = pictures["flow_time"].figure.axes[0], pictures["flow_time"].figure.axes[2]
    assert before.get_title().endswith('record "fit", before')
    assert after.get_title().endswith('record "fit", after')
    assert before.get_ylim()[1] > 3.0 * after.get_ylim()[1]
    _, _, error_before, _, error_after, _ = pictures["simulation"].figure.axes[:6]
    assert error_before.get_ylim()[1] > 3.0 * error_after.get_ylim()[1]
    assert "its spread (± 1 std), after" in [
        text.get_text() for text in pictures["flow_signals"].figure.legends[0].texts
    ]
    (evidence, *_) = pictures["flow_evidence"].figure.axes
    first = diagnosis.results[0].steps[0].candidates[0]
    asked = next(line.get_xdata()[0] for line in evidence.lines if line.get_linewidth() == 2.0)
    assert asked == pytest.approx(first.asked_deviations)
    assert evidence.texts[0].get_text() in (f"{first.deviations:.1f}", f"{first.deviations:.0f}")


def test_the_simulated_curves_are_of_the_plants_whose_errors_are_told(diagnosis: Diagnosis) -> None:
    """Far from noise these are fits to free runs: 8 mm was drawn where 1.84 mm stood in the table."""
    assert diagnosis.simulation is not None
    errors = diagnosis.errors

    def drawn(fitted: BeforeAfter) -> list[float]:
        of = replace(diagnosis, errors=replace(errors, fit=fitted))
        (record, *_) = simulation_data(of, of.simulation).records
        (position, *_) = record.quantities
        off = [(position.measured - position.simulated[side])[SETTLED:] for side in ("before", "after")]
        return [float(np.sqrt(np.mean(one**2))) / 1e3 for one in off]  # drawn in mm

    told = [errors.fit.before.position, errors.fit.after.position]
    assert drawn(errors.fit) == pytest.approx(told, rel=1e-6)
    assert drawn(BeforeAfter(errors.fit.after, errors.fit.before)) == pytest.approx(told[::-1], rel=1e-6)


def test_a_figure_says_what_keeps_the_plant_beside_its_record(diagnosis: Diagnosis) -> None:
    assert diagnosis.simulation is not None
    how = diagnosis.simulation.how
    ways = [how, replace(how, crossover=5.0), replace(how, is_beside=True)]
    titles, captions = zip(*(_kept(replace(diagnosis.simulation, how=way)) for way in ways), strict=True)
    assert titles == (
        "from the measured input alone",
        "and led along the record by a loop of 5 rad/s",
        "and kept beside the record by a filter",
    )
    assert captions[1] == "a force on its mass by which a loop of 5 rad/s leads it along the record"


def test_the_noise_of_a_quick_machine_is_what_its_plant_leaves(diagnosis: Diagnosis) -> None:
    """Oil that swings nearly as fast as it is sampled scatters from sample to sample as a sensor's noise would."""
    motion, draw = diagnosis.results[0].balance.motions[0], np.random.default_rng(1)
    simulated = {
        name: values + motion.sensed[name] * draw.standard_normal(values.size)
        for name, values in motion.measured.items()
    }
    of_pressure = 1e-3 * np.hypot(motion.sensed["pressure_1"], motion.sensed["pressure_2"])
    true = {"position": 1e3 * motion.sensed["position"], "load pressure": of_pressure}
    for times, told in ((1.0, 1.0), (6.0, 1.0), (0.5, 0.5)):
        shown = replace(motion, sensed={name: times * std for name, std in motion.sensed.items()})
        compared = _compared(diagnosis, shown, {"before": simulated, "after": simulated})
        assert {one.words: one.noise for one in compared} == pytest.approx(
            {words: told * std for words, std in true.items()}, rel=0.05
        )


def test_a_bar_of_evidence_ends_where_its_candidate_stands_out() -> None:
    """On an axis of decades from 0.3 on, with room for what is asked and for the numbers."""
    bars = [CandidateBar("a", 250.4, 4.0, "added", True), CandidateBar("b", 3.26, 4.5, "", False)]
    nothing = CandidateBar("c", 0.0, 4.0, "", False)
    picture = draw_evidence(EvidenceData("force", "force", [EvidenceRound("round 1", [*bars, nothing])]))
    (axes,) = picture.figure.axes
    assert axes.get_xscale() == "log"
    assert axes.get_xlim() == pytest.approx((LEAST_SHOWN, 2.0 * 250.4))
    ends = [patch.get_x() + patch.get_width() for patch in axes.patches]
    assert ends == pytest.approx([250.4, 3.26, LEAST_SHOWN])
    assert [text.get_text() for text in axes.texts] == ["250", "3.3", "0.0"]
    assert all(axes.texts[k].get_position()[0] > bars[k].asked for k in range(2)), "behind the bar and its mark"
    marks = [line.get_xdata()[0] for line in axes.lines if line.get_linewidth() == 2.0]
    assert marks == [4.0, 4.5, 4.0]
    assert [label.get_text() for label in axes.get_yticklabels()] == ["a", "b", "c"]
    picture.figure.canvas.draw()
    shown = [label.get_text() for label in axes.get_xticklabels() if label.get_text()]
    assert {"1", "10", "100"} <= set(shown), "plain numbers"
    said = [text.get_text() for text in picture.figure.legends[0].texts]
    assert said == ["added", "asked for: at least", "not added"]


def test_every_round_of_evidence_has_a_panel() -> None:
    rounds = [EvidenceRound(f"round {k}", [CandidateBar("a", float(k), 2.5, "", True)]) for k in (1, 2, 3)]
    figure = draw_evidence(EvidenceData("flow", "flow", rounds)).figure
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["round 1", "round 2", "round 3"]
    assert len({axes.get_xlim() for axes in figure.axes}) == 1, "bars of all rounds can be compared"


def test_the_signal_that_a_found_effect_acts_on_is_shown(diagnosis: Diagnosis) -> None:
    balance = diagnosis.results[0].balance
    part = parts_of(diagnosis, balance)[0]
    assert "load_pressure" in shown_signals(diagnosis, balance, part)
    assert not {"pressure_1", "acceleration"} & set(shown_signals(diagnosis, balance, part))
    late = replace(diagnosis.effects[0], name="frictional_memory")
    assert "acceleration" in shown_signals(replace(diagnosis, effects=[late]), balance, part)
    one_sided = {name: values for name, values in part.motion.channels.items() if name != "pressure_2"}
    seal = replace(part, motion=replace(part.motion, channels=one_sided))
    assert "pressure_1" in shown_signals(diagnosis, balance, seal)


# --- series ---


def test_bins_show_what_a_residual_depends_on() -> None:
    generator = np.random.default_rng(5)
    signal = generator.uniform(-1.0, 1.0, 24000)
    residual = 3.0 * signal**2 + 0.1 * generator.standard_normal(24000)
    residual[::50] = np.nan
    centre, mean, spread = binned(signal, residual)
    assert centre.size == 24
    np.testing.assert_allclose(mean[2:-2], 3.0 * centre[2:-2] ** 2, atol=0.02)
    assert np.all(spread < 0.25)


@pytest.mark.parametrize("seed", range(4))
def test_no_autocorrelation_is_above_one(seed: int) -> None:
    """Where few pairs are left, these are as large as they happen to be."""
    draw = np.random.default_rng(seed)
    slow = np.sin(0.02 * np.arange(400)) * draw.uniform(0.1, 10.0, 400)
    slow[draw.random(400) < 0.9] = np.nan
    _, values, _ = autocorrelation([slow])
    assert values[0] == pytest.approx(1.0)
    assert np.max(np.abs(values)) <= 1.0 + 1e-12


def test_autocorrelation_of_a_first_order_process_with_gaps() -> None:
    """phi^k, whatever is missing."""
    noise = np.random.default_rng(6).standard_normal(40_000)
    for k in range(1, noise.size):
        noise[k] += 0.8 * noise[k - 1]
    noise[10_000:20_000] = np.nan
    lags, values, white = autocorrelation([noise[:30_000], noise[30_000:]])
    np.testing.assert_allclose(values[:6], 0.8 ** np.arange(6), atol=0.03)
    assert lags[1] == pytest.approx(0.01)
    assert white == pytest.approx(1.96 / np.sqrt(30_000), rel=1e-6)
