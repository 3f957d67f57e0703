"""What each candidate effect is worth: by how much it stands out of the noise."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.diagnose.report.figures.frame import WIDE
from workbench.diagnose.report.series import title_of
from workbench.diagnose.report.tables import outcome
from workbench.diagnose.selection.selection import BalanceResult, Step
from workbench.publish.pictures import Picture
from workbench.publish.style import COLOURS, figure_style, plain_numbers
from workbench.publish.words import plain_name

OUTCOMES = {"added": COLOURS[0], "as good": COLOURS[5], "": "#bbbbbb"}
OUTCOME_WORDS = {"added": "added", "as good": "as good: cannot be told from it", "": "not added"}
"""Colour of a bar, and words for it in the legend, by what became of a candidate."""

LEAST_SHOWN = 0.3
"""Standard deviations at which a bar begins: on a logarithmic axis there is no 0."""


@dataclass(frozen=True)
class CandidateBar:
    """A candidate: by how many standard deviations of the noise it stands out, how many are asked of it to be added,
    what became of it, and whether it was fitted, or its worth is that of first order.
    """

    name: str
    deviations: float
    asked: float
    outcome: str
    fitted: bool


@dataclass(frozen=True)
class EvidenceRound:
    """One round: how it ended, and all candidates from the best."""

    title: str
    bars: Sequence[CandidateBar]


@dataclass(frozen=True)
class EvidenceData:
    """The rounds of a balance."""

    balance: str
    title: str
    rounds: Sequence[EvidenceRound]

    @property
    def widest(self) -> float:
        """The most standard deviations of any round."""
        return max(max(bar.deviations, bar.asked) for round_ in self.rounds for bar in round_.bars)


MOST_BARS = 12
"""Candidates that are drawn in a round, from the best."""


def evidence_data(result: BalanceResult) -> EvidenceData:
    """The numbers of the figure: what every candidate of every round is worth."""
    rounds = []
    for number, step in enumerate([step for step in result.steps if step.candidates], 1):
        bars = [
            CandidateBar(
                plain_name(candidate.effect),
                candidate.deviations,
                candidate.asked_deviations,
                outcome(step, candidate.effect),
                candidate.fit is not None,
            )
            for candidate in step.candidates[:MOST_BARS]
        ]
        rounds.append(EvidenceRound(f"round {number}: {_ending(step)}", bars))
    return EvidenceData(result.balance.name, title_of(result.balance), rounds)


def _ending(step: Step) -> str:
    if not step.added and not step.dropped:
        return "none is added"
    words = [f"{plain_name(effect)} is added" for effect in step.added]
    return "; ".join([*words, *(f"{plain_name(effect)} is dropped" for effect in step.dropped)])


def draw_evidence(data: EvidenceData) -> Picture:
    """The figure: a panel a round, a bar a candidate."""
    counts = [len(round_.bars) for round_ in data.rounds]
    with figure_style():
        figure = Figure(figsize=(WIDE, 0.26 * sum(counts) + 0.9 * len(counts) + 0.7))
        FigureCanvasAgg(figure)
        figure.suptitle(f"{data.title}: which effect stands out of the noise?")
        panels = figure.subplots(len(counts), squeeze=False, height_ratios=[count + 1.5 for count in counts])[:, 0]
        drawn: dict[str, Any] = {}
        for axes, round_ in zip(panels, data.rounds, strict=True):
            for place, bar in enumerate(round_.bars):
                end = max(bar.deviations, LEAST_SHOWN)
                patch = axes.barh(place, end - LEAST_SHOWN, left=LEAST_SHOWN, color=OUTCOMES[bar.outcome], height=0.7)
                drawn.setdefault(OUTCOME_WORDS[bar.outcome], patch)
                ends = (place - 0.42, place + 0.42)
                drawn.setdefault("asked for: at least", axes.plot((bar.asked,) * 2, ends, "k", linewidth=2.0)[0])
                said = f"{bar.deviations:.1f}" if bar.deviations < 100.0 else f"{bar.deviations:.0f}"
                axes.text(1.04 * max(end, bar.asked), place, said, va="center", fontsize=7)
            axes.set_yticks(range(len(round_.bars)), [bar.name for bar in round_.bars])
            axes.set_ylim(len(round_.bars) - 0.4, -0.6)
            axes.set_xscale("log")
            axes.set_xlim(LEAST_SHOWN, 2.0 * data.widest)
            plain_numbers(axes.xaxis)
            axes.grid(visible=False, axis="y")
            axes.set_title(round_.title, fontsize="small", loc="left")
            axes.set_xlabel("stands out by so many standard deviations of the noise")
        figure.legend(list(drawn.values()), list(drawn), loc="outside lower center", ncols=len(drawn))
    caption = (
        "What each candidate gains in likelihood, fitted together with the plant's own parameters, as the number of "
        "standard deviations by which a single number would stand out that gains as much. To be added a bar has to "
        "reach its black mark, which counts how many candidates there are and how many numbers each has. Candidates "
        "that promise little are judged to first order. They stand in the order of what they gain beyond what is "
        "asked; the twelve best of each round are drawn, and the table has all."
    )
    return Picture(figure, caption, data.balance)
