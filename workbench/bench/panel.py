"""The controls of a group on the page: sliders with what may be typed, choices, switches."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from html import escape
from typing import Any

from bokeh.layouts import column, row
from bokeh.models import CustomJS, InlineStyleSheet
from bokeh.models.dom import HTML
from bokeh.models.ui.tooltips import Tooltip
from bokeh.models.widgets.inputs import Select, TextInput
from bokeh.models.widgets.inputs import Switch as SwitchWidget
from bokeh.models.widgets.markups import Div
from bokeh.models.widgets.sliders import Slider

from workbench.bench.groups import controls_of
from workbench.bench.knobs import Choice, Control, Knob, Switch
from workbench.bench.looks import WIDGETS, Options
from workbench.bench.loop import Change
from workbench.bench.outcome import Outcome
from workbench.bench.pace import MOVED

UNFILLED = ".noUi-connect { background: none !important; }"
"""Of a slider's track: what is left of the handle hides no colour."""

STEPS = 400
"""Places of a slider."""


@dataclass
class _Shown:
    """A knob as it stands on the page; `track` colours its slider."""

    knob: Knob
    text: TextInput
    slider: Slider
    track: InlineStyleSheet


@dataclass(frozen=True)
class Hands:
    """What is to be done when somebody turns a knob, chooses a name, flips a switch, or types what is wrong."""

    turned: Callable[[Change], None]
    chosen: Callable[[str, str], None]
    flipped: Callable[[Change], None]
    wrong: Callable[[str], None]


class ControlPanel:
    """The group that is shown, and its controls."""

    def __init__(self, groups: Mapping[str, str], hands: Hands, show: Callable[[], None]) -> None:
        self._hands = hands
        self.group = next(iter(groups))
        self._shown: dict[str, _Shown] = {}
        self._quiet = False
        titles: Options = [*groups.items()]
        choose = Select(
            options=titles,
            value=self.group,
            title="What to turn",
            stylesheets=[WIDGETS],
            sizing_mode="stretch_width",
            name="group",
        )
        choose.on_change("value", lambda _attr, _old, new: self._choose(str(new), show))
        self._column = column(Div(), sizing_mode="stretch_width")
        self.layout = column(choose, self._column, sizing_mode="stretch_width", name="controls")

    def _choose(self, group: str, show: Callable[[], None]) -> None:
        self.group = group
        show()

    def show(self, outcome: Outcome) -> None:
        """The controls of the group, as they are for a loop."""
        self._shown = {}
        self._column.children = [self._widget(control) for control in controls_of(self.group, outcome)]

    @property
    def knobs(self) -> list[Knob]:
        """The knobs that are shown, as they stand."""
        return [shown.knob for shown in self._shown.values()]

    def refresh(self, change: Change) -> bool:
        """Texts and sliders of the knobs that were turned; false where one went beyond its slider, which is then to be
        shown anew.
        """
        self._quiet, within = True, True
        for key, value in change.items():
            shown = self._shown.get(key)
            if shown is None or not isinstance(value, float):
                continue
            shown.knob = shown.knob.turned(change)
            shown.text.value = shown.knob.text
            if abs(shown.knob.place - float(shown.slider.value)) > 1.0 / STEPS:
                shown.slider.value = shown.knob.place
            within &= shown.knob.low <= shown.knob.value <= shown.knob.high or shown.knob.may_be_off
        self._quiet = False
        return within

    def restore(self) -> None:
        """Texts and sliders as they were, where what was turned is refused."""
        self._quiet = True
        for shown in self._shown.values():
            shown.text.value = shown.knob.text
            shown.slider.value = shown.knob.place
        self._quiet = False

    def mark(self, key: str, low: float, high: float) -> None:
        """Colour a slider beyond these places, where the linearised loop is unstable."""
        shown = self._shown.get(key)
        if shown is not None:
            stops = f"var(--bad) {100 * low:.1f}%, var(--line) {100 * low:.1f}%, var(--line) {100 * high:.1f}%"
            track = f"linear-gradient(to right, {stops}, var(--bad) {100 * high:.1f}%)"
            shown.track.css = f".noUi-target {{ background: {track} !important; }} {UNFILLED}"

    def _widget(self, control: Control) -> Any:
        if isinstance(control, Knob):
            return self._knob(control)
        return self._choice(control) if isinstance(control, Choice) else self._switch(control)

    def _knob(self, knob: Knob) -> Any:
        tip: Any = {"description": Tooltip(content=HTML(html=escape(knob.tip)), position="right")} if knob.tip else {}
        text = TextInput(
            title=knob.label, value=knob.text, sizing_mode="stretch_width", stylesheets=[WIDGETS], name=knob.key, **tip
        )
        track = InlineStyleSheet(css=UNFILLED)
        slider = Slider(
            start=0.0,
            end=1.0,
            step=1.0 / STEPS,
            value=knob.place,
            show_value=False,
            tooltips=False,
            sizing_mode="stretch_width",
            stylesheets=[WIDGETS, track],
            name=f"slider {knob.key}",
            margin=(0, 14, 8, 14),
        )
        self._shown[knob.key] = _Shown(knob, text, slider, track)
        slider.js_on_change("value", CustomJS(code=MOVED))
        slider.on_change("value", lambda _attr, _old, place: self._turn(knob, knob.at(float(place))))
        text.on_change("value", lambda _attr, _old, typed: self._typed(knob, str(typed)))
        return column(text, slider, sizing_mode="stretch_width")

    def _turn(self, knob: Knob, value: float) -> None:
        if not self._quiet:
            self._hands.turned(knob.change(value))

    def _typed(self, knob: Knob, typed: str) -> None:
        if self._quiet:
            return
        try:
            value = knob.read(typed)
        except ValueError as error:
            self._hands.wrong(f"{knob.label}: {error}")
            return
        self._hands.turned(knob.change(value))

    def _choice(self, choice: Choice) -> Any:
        options: Options = [*choice.options]
        select = Select(
            title=choice.label,
            value=choice.value,
            options=options,
            sizing_mode="stretch_width",
            stylesheets=[WIDGETS],
            name=choice.key,
        )
        select.on_change("value", lambda _attr, _old, new: self._hands.chosen(choice.key, str(new)))
        return select

    def _switch(self, switch: Switch) -> Any:
        button = SwitchWidget(active=switch.value, name=switch.key, margin=(8, 4, 4, 8))
        button.on_change("active", lambda _attr, _old, on: self._hands.flipped(switch.on if on else switch.off))
        words = f"{escape(switch.label)}<br><small>{escape(switch.tip)}</small>"
        return row(button, Div(text=words, stylesheets=[WIDGETS], width=230))
