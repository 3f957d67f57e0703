"""What each candidate effect is worth, on data that its fit has not seen."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.diagnose.report.figures.frame import WIDE
from workbench.diagnose.report.names import percent
from workbench.diagnose.report.series import scale_of, title_of, unit_of
from workbench.diagnose.report.tables import outcome
from workbench.diagnose.selection.selection import LEAST_GAIN, BalanceResult, Candidate, Step, gain, least_gain
from workbench.diagnose.simulation.promising import EXPLAINS
from workbench.diagnose.simulation.shooting import SIMULATION
from workbench.publish.pictures import Picture
from workbench.publish.style import COLOURS, figure_style
from workbench.publish.words import plain_name

OUTCOMES = {"added": COLOURS[0], "as good": COLOURS[5], "": "#bbbbbb"}
OUTCOME_WORDS = {"added": "added", "as good": "as good: cannot be told from it", "": "not added"}
"""Colour of a bar, and words for it in the legend, by what became of a candidate."""

MOST_SHOWN = 2.0
"""Times the rms where nothing is added: a bar that is longer, of a gain below -100 %, would make all others short."""


@dataclass(frozen=True)
class CandidateBar:
    """A candidate: left-out `rms` with it, which it had to get below to be added (`asked`), its gain as a share and in
    standard errors, and what became of it.
    """

    name: str
    rms: float
    asked: float
    share: float
    standard_errors: float
    outcome: str


@dataclass(frozen=True)
class EvidenceRound:
    """One round: how it ended, left-out rms where nothing is added, and all candidates from the best."""

    title: str
    before: float
    bars: Sequence[CandidateBar]

    @property
    def widest(self) -> float:
        """The largest rms of the round that its panel has room for."""
        return min(max(self.before, *(bar.rms for bar in self.bars)), MOST_SHOWN * self.before)

    def end(self, floor: float) -> float:
        """Where the axis ends, with room for words beside the bars; `floor` is shown too."""
        return 1.3 * max(self.widest, floor)


@dataclass(frozen=True)
class EvidenceData:
    """The rounds of a balance, with its noise floor, all in `unit`."""

    balance: str
    title: str
    unit: str
    floor: float
    rounds: Sequence[EvidenceRound]


def evidence_data(result: BalanceResult) -> EvidenceData:
    """The numbers of the figure: left-out rms of every candidate of every round."""
    balance, scale = result.balance, scale_of(result.balance)
    rounds = []
    for number, step in enumerate([step for step in result.steps if step.candidates], 1):
        bars = [
            CandidateBar(
                plain_name(candidate.effect),
                scale * candidate.fit.validated_rms,
                scale * threshold(step, candidate),
                *gain(step.before, candidate.fit),
                outcome(step, candidate.effect),
            )
            for candidate in step.candidates
        ]
        title = f"round {number}: {_ending(step)}"
        rounds.append(EvidenceRound(title, scale * step.before.validated_rms, bars))
    return EvidenceData(balance.name, title_of(balance), unit_of(balance), scale, rounds)


def threshold(step: Step, candidate: Candidate) -> float:
    """Residual rms on blocks left out (floors) that a candidate has to get below to be added."""
    balance, before = step.before.balance, step.before
    if balance.name != SIMULATION:
        return before.validated_rms * (1.0 - least_gain(candidate.effect, len(candidate.variant), balance))
    if set(candidate.variant) & set(before.names):  # it is there, and gains a parameter
        return before.validated_rms * (1.0 - LEAST_GAIN)
    beyond = max(before.validated_rms**2 - 1.0, 0.0)
    return float(min(before.validated_rms * (1.0 - LEAST_GAIN), (before.validated_rms**2 - EXPLAINS * beyond) ** 0.5))


def _ending(step: Step) -> str:
    if step.added is None:
        return "none is added"
    also = f"; as good: {', '.join(map(plain_name, step.alternatives))}" if step.alternatives else ""
    return f"{plain_name(step.added.effect)} is added{also}"


def _write_gain(axes: Axes, place: int, bar: CandidateBar, round_: EvidenceRound, floor: float) -> None:
    """What a candidate gains, beside its bar; at the end of one that leaves no room, or that the axis cuts off."""
    end, text = round_.end(floor), f"gain {percent(bar.share, 1)}"
    if bar.rms > max(round_.widest, floor):
        text += " (cut off)" if bar.rms > end else ""
        axes.text(min(bar.rms, end) - 0.01 * round_.widest, place, text, ha="right", va="center", fontsize=7)
        return
    text += f", {bar.standard_errors:.1f} std. errors" if bar.share > 0.005 else ""
    marks = (bar.rms, round_.before, bar.asked, floor)
    beside = max(mark for mark in marks if bar.rms <= mark < bar.rms + 0.25 * round_.widest)
    axes.text(beside + 0.01 * round_.widest, place, text, va="center", fontsize=7)


def draw_evidence(data: EvidenceData) -> Picture:
    """The figure: a panel a round, a bar a candidate."""
    counts = [len(round_.bars) for round_ in data.rounds]
    with figure_style():
        figure = Figure(figsize=(WIDE, 0.26 * sum(counts) + 0.9 * len(counts) + 0.7))
        FigureCanvasAgg(figure)
        figure.suptitle(f"{data.title}: which effect lowers the residual on data that its fit has not seen?")
        panels = figure.subplots(len(counts), squeeze=False, height_ratios=[count + 1.5 for count in counts])[:, 0]
        drawn: dict[str, Any] = {}
        for axes, round_ in zip(panels, data.rounds, strict=True):
            for place, bar in enumerate(round_.bars):
                patch = axes.barh(place, bar.rms, color=OUTCOMES[bar.outcome], height=0.7)
                drawn.setdefault(OUTCOME_WORDS[bar.outcome], patch)
                ends = (place - 0.42, place + 0.42)
                drawn.setdefault("asked for: at most", axes.plot((bar.asked,) * 2, ends, "k", linewidth=2.0)[0])
                _write_gain(axes, place, bar, round_, data.floor)
            drawn.setdefault("nothing added", axes.axvline(round_.before, color="black", linestyle="--", linewidth=1.2))
            drawn.setdefault("noise floor", axes.axvline(data.floor, color=COLOURS[2], linestyle=":", linewidth=1.8))
            axes.set_yticks(range(len(round_.bars)), [bar.name for bar in round_.bars])
            axes.set_ylim(len(round_.bars) - 0.4, -0.6)
            axes.set_xlim(0.0, round_.end(data.floor))
            axes.grid(visible=False, axis="y")
            axes.set_title(round_.title, fontsize="small", loc="left")
            axes.set_xlabel(f"residual on blocks left out of the fit, rms ({data.unit})")
        figure.legend(list(drawn.values()), list(drawn), loc="outside lower center", ncols=len(drawn))
    caption = (
        "Each candidate is fitted together with the plant's own parameters on all blocks of the records but one, and "
        "judged on that one. The dashed line is what is left where nothing is added; to be added a bar has to end left "
        "of its black mark, by enough standard errors over the blocks. None can be much shorter than the noise floor. "
        "The gain is the share by which a candidate lowers that rms."
    )
    return Picture(figure, caption, data.balance)
