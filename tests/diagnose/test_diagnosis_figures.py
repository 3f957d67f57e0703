"""What the figures of a diagnosis show, and the series in them."""

from dataclasses import replace

import numpy as np
import pytest
from diagnoses import doubting

from workbench.diagnose.report.figures.every import pictures_of
from workbench.diagnose.report.figures.evidence import CandidateBar, EvidenceData, EvidenceRound, draw_evidence
from workbench.diagnose.report.figures.parameters import draw_parameters, parameters_data
from workbench.diagnose.report.series import autocorrelation, binned, parts_of, shown_signals
from workbench.diagnose.result import Diagnosis


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
    asked = next(line.get_xdata()[0] for line in evidence.lines if line.get_linewidth() == 2.0)
    nothing = next(line.get_xdata()[0] for line in evidence.lines if line.get_linestyle() == "--")
    assert asked == pytest.approx(0.95 * nothing)  # 4 %, and 1 % for the one parameter
    assert any(text.get_text().startswith("gain ") for text in evidence.texts)


def test_a_bar_of_evidence_far_off_is_cut_and_says_its_gain() -> None:
    """-496 %: the axis would be six times as long as what it is about."""
    bars = [CandidateBar(name, rms, 0.95, 1.0 - rms, 0.1, "") for name, rms in (("a", 0.99), ("b", 2.3), ("c", 5.96))]
    picture = draw_evidence(EvidenceData("force", "force", "N", 0.5, [EvidenceRound("round 1", 1.0, bars)]))
    (axes,) = picture.figure.axes
    low, high = axes.get_xlim()
    assert (low, high) == (0.0, pytest.approx(2.6))
    texts = {round(text.get_position()[1]): text for text in axes.texts}
    assert [texts[place].get_text() for place in range(3)] == [
        "gain 1.0 %, 0.1 std. errors",
        "gain -130.0 %",
        "gain -496.0 % (cut off)",
    ]
    assert [texts[place].get_ha() for place in range(3)] == ["left", "right", "right"]
    assert texts[1].get_position()[0] < 2.3
    assert texts[2].get_position()[0] < high


def test_the_axis_of_evidence_holds_every_bar_that_is_not_far_off() -> None:
    bars = [CandidateBar("a", 0.9, 0.95, 0.1, 3.0, "added"), CandidateBar("b", 1.5, 0.95, -0.5, -1.0, "")]
    data = EvidenceData("force", "force", "N", 0.5, [EvidenceRound("round 1", 1.0, bars)])
    (axes,) = draw_evidence(data).figure.axes
    assert axes.get_xlim() == (0.0, pytest.approx(1.3 * 1.5))
    assert axes.texts[1].get_text() == "gain -50.0 %"
    assert axes.texts[1].get_position()[0] > 1.5


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
