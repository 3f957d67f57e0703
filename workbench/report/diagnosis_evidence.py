"""Figures of a diagnosis that are not residuals: what each candidate effect is worth, and the fitted parameters."""

from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from workbench.diagnose.diagnose import Diagnosis
from workbench.diagnose.selection import BalanceResult, Step, gain
from workbench.report.diagnosis_series import scale_of, title_of, unit_of
from workbench.report.diagnosis_tables import INTERVAL, outcome, parameter_rows
from workbench.report.diagnosis_words import REJECTED, plain
from workbench.report.style import COLOURS, figure_style

BEFORE, AFTER = COLOURS[1], COLOURS[0]
OUTCOMES = {"added": COLOURS[0], "as good": COLOURS[5], "": "#bbbbbb"}
SAID = {"added": "added", "as good": "as good: cannot be told from it", "": "not supported"}

WIDE = 9.0
"""Inches of a figure with two columns."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure with what a reader has to know to judge it; `balance` is empty for what concerns all."""

    figure: Figure
    caption: str
    balance: str = ""


def legend(figure: Figure, axes: Axes) -> None:
    """One legend for all panels, under them."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2 if len(labels) > 3 else 3)


def evidence(result: BalanceResult) -> Picture:
    """Left-out rms of every candidate of every round, against that without any and against the floor."""
    steps = [step for step in result.steps if step.candidates]
    scale, unit = scale_of(result.balance), unit_of(result.balance)
    with figure_style():
        counts = [len(step.candidates) for step in steps]
        figure = Figure(figsize=(WIDE, 0.26 * sum(counts) + 0.9 * len(steps) + 0.7))
        FigureCanvasAgg(figure)
        figure.suptitle(f"{title_of(result.balance)}: which effect explains data that was left out?")
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
                change = f"{-100.0 * share:+.1f} %" if abs(share) >= 0.0005 else "0 %"
                text = change + (f", {sure:.1f} std. errors" if share > 0.005 else "")
                crossed = [one for one in (rms, base, scale) if rms <= one < rms + 0.25 * widest]
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
        "judged on that one: a bar that is clearly shorter than the dashed line is an effect that the data support. "
        "None can be much shorter than the noise floor."
    )
    return Picture(figure, caption, result.balance.name)


def _round(step: Step) -> str:
    if step.added is None:
        return "none is added"
    also = f"; as good: {', '.join(map(plain, step.alternatives))}" if step.alternatives else ""
    return f"{plain(step.added.effect)} is added{also}"


def parameters_figure(found: Diagnosis) -> Picture | None:
    """Fitted over declared values with 95 % intervals; None where nothing that was declared was fitted."""
    rows = {name: row for name, row in parameter_rows(found).items() if row["declared"] and "baseline" in row}
    if not rows:
        return None
    with figure_style():
        figure = Figure(figsize=(WIDE, 0.38 * len(rows) + 1.3))
        FigureCanvasAgg(figure)
        figure.suptitle("Parameters: fitted over declared")
        axes = figure.subplots()
        axes.axvline(1.0, color="black", linestyle="--", linewidth=1.0, label="declared")
        ratios = []
        last = "with what was rejected" if found.report["verdict"] == REJECTED else "with what was found"
        sides = (("baseline", "baseline: declared plant, fitted", BEFORE, -0.14), ("fitted", last, AFTER, 0.14))
        for place, row in enumerate(rows.values()):
            for key, said, colour, shift in sides if found.found else sides[:1]:
                value, std = (number / row["declared"] for number in row[key])
                style: dict[str, Any] = {"color": colour, "capsize": 2.5, "fmt": "o" if key == "baseline" else "s"}
                missed = key == "baseline" and not row["identified"]
                style |= {"markerfacecolor": "white"} if missed else {}
                half = abs(INTERVAL * std)
                low = min(half, 0.999 * abs(value))
                axes.errorbar(value, place + shift, xerr=[[low], [half]], label=None if place else said, **style)
                ratios += [abs(value)]
        if max(ratios) > 4.0 * min(ratios):
            axes.set_xscale("log")
            axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axes.xaxis.set_major_formatter("{x:g}")
            axes.xaxis.set_minor_formatter(NullFormatter())
        labels = [name + ("" if row["identified"] else " (not identified)") for name, row in rows.items()]
        axes.set_yticks(range(len(rows)), labels)
        axes.set_ylim(len(rows) - 0.5, -0.5)
        axes.set_xlabel("fitted value over declared value")
        legend(figure, axes)
    caption = (
        "Each parameter that the fit may move, over its declared value, with its 95 % interval; autocorrelation of the "
        "residual is taken into account. An open circle is not identified: its standard deviation exceeds half its "
        "value."
    )
    return Picture(figure, caption)
