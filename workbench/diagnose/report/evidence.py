"""Figures of a diagnosis: what each candidate effect is worth, on data that its fit has not seen."""

from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.diagnose.report.names import percent, plain
from workbench.diagnose.report.series import scale_of, title_of, unit_of
from workbench.diagnose.report.tables import outcome
from workbench.diagnose.selection.promising import EXPLAINS
from workbench.diagnose.selection.selection import LEAST_GAIN, BalanceResult, Candidate, Step, gain, least_gain
from workbench.diagnose.simulation.shooting import SIMULATION
from workbench.publish.style import COLOURS, figure_style

BEFORE, AFTER = COLOURS[1], COLOURS[0]
OUTCOMES = {"added": COLOURS[0], "as good": COLOURS[5], "": "#bbbbbb"}
SAID = {"added": "added", "as good": "as good: cannot be told from it", "": "not added"}

WIDE = 9.0
"""Inches of a figure with two columns."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure with what a reader has to know to judge it; `balance` is empty for what concerns all."""

    figure: Figure
    caption: str
    balance: str = ""


def legend(figure: Figure, *panels: Axes) -> None:
    """One legend for all panels, under them, of what these have."""
    drawn: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            drawn.setdefault(label, handle)
    figure.legend(list(drawn.values()), list(drawn), loc="outside lower center", ncols=2 if len(drawn) > 3 else 3)


def evidence(result: BalanceResult) -> Picture:
    """Left-out rms of every candidate of every round, against that without any and against the floor."""
    steps = [step for step in result.steps if step.candidates]
    scale, unit = scale_of(result.balance), unit_of(result.balance)
    with figure_style():
        counts = [len(step.candidates) for step in steps]
        figure = Figure(figsize=(WIDE, 0.26 * sum(counts) + 0.9 * len(steps) + 0.7))
        FigureCanvasAgg(figure)
        figure.suptitle(
            f"{title_of(result.balance)}: which effect lowers the residual on data that its fit has not seen?"
        )
        panels = figure.subplots(len(steps), squeeze=False, height_ratios=[count + 1.5 for count in counts])[:, 0]
        drawn: dict[str, Any] = {}
        for number, (axes, step) in enumerate(zip(panels, steps, strict=True), 1):
            base = scale * step.before.validated_rms
            widest = max(base, scale * max(one.fit.validated_rms for one in step.candidates))
            for place, one in enumerate(step.candidates):
                became, rms = outcome(step, one.effect), scale * one.fit.validated_rms
                share, sure = gain(step.before, one.fit)
                bar = axes.barh(place, rms, color=OUTCOMES[became], height=0.7)
                drawn.setdefault(SAID[became], bar)
                asked = scale * threshold(step, one)
                ends = (place - 0.42, place + 0.42)
                drawn.setdefault("asked for: at most", axes.plot((asked, asked), ends, "k", linewidth=2.0)[0])
                text = f"gain {percent(share, 1)}" + (f", {sure:.1f} std. errors" if share > 0.005 else "")
                crossed = [one for one in (rms, base, asked, scale) if rms <= one < rms + 0.25 * widest]
                axes.text(max(crossed) + 0.01 * widest, place, text, va="center", fontsize=7)
            drawn.setdefault("nothing added", axes.axvline(base, color="black", linestyle="--", linewidth=1.2))
            drawn.setdefault("noise floor", axes.axvline(scale, color=COLOURS[2], linestyle=":", linewidth=1.8))
            axes.set_yticks(range(counts[number - 1]), [plain(one.effect) for one in step.candidates])
            axes.set_ylim(counts[number - 1] - 0.4, -0.6)
            axes.set_xlim(0.0, 1.3 * max(widest, scale))
            axes.grid(visible=False, axis="y")
            axes.set_title(f"round {number}: " + _round(step), fontsize="small", loc="left")
            axes.set_xlabel(f"residual on blocks left out of the fit, rms ({unit})")
        figure.legend(list(drawn.values()), list(drawn), loc="outside lower center", ncols=len(drawn))
    caption = (
        "Each candidate is fitted together with the plant's own parameters on all blocks of the records but one, and "
        "judged on that one. The dashed line is what is left where nothing is added; to be added a bar has to end left "
        "of its black mark, by enough standard errors over the blocks. None can be much shorter than the noise floor. "
        "The gain is the share by which a candidate lowers that rms."
    )
    return Picture(figure, caption, result.balance.name)


def threshold(step: Step, one: Candidate) -> float:
    """Residual rms on blocks left out (floors) that a candidate has to get below to be added."""
    balance, before = step.before.balance, step.before
    if balance.name != SIMULATION:
        return before.validated_rms * (1.0 - least_gain(one.effect, len(one.variant), balance))
    if set(one.variant) & set(before.names):  # it is there, and gains a parameter
        return before.validated_rms * (1.0 - LEAST_GAIN)
    beyond = max(before.validated_rms**2 - 1.0, 0.0)
    return float(min(before.validated_rms * (1.0 - LEAST_GAIN), (before.validated_rms**2 - EXPLAINS * beyond) ** 0.5))


def _round(step: Step) -> str:
    if step.added is None:
        return "none is added"
    also = f"; as good: {', '.join(map(plain, step.alternatives))}" if step.alternatives else ""
    return f"{plain(step.added.effect)} is added{also}"
