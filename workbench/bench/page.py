"""The page of the bench: controls at the left, figures of the run above its scopes, a sweep below."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from html import escape
from pathlib import Path
from typing import Any

from bokeh.document import Document
from bokeh.layouts import column, row
from bokeh.models import CustomJS
from bokeh.models.widgets.buttons import Button, Toggle
from bokeh.models.widgets.groups import CheckboxButtonGroup
from bokeh.models.widgets.inputs import Checkbox, TextInput
from bokeh.models.widgets.markups import Div
from jinja2 import Template

from workbench.bench.curves import ScopeFigure
from workbench.bench.figures_table import figures_table
from workbench.bench.groups import chosen, groups_of
from workbench.bench.knobs import Knob
from workbench.bench.link import decoded, encoded
from workbench.bench.looks import WIDGETS, WRAPPED
from workbench.bench.loop import BenchLoop, Change
from workbench.bench.outcome import Outcome, outcome_of
from workbench.bench.pace import Pace
from workbench.bench.panel import ControlPanel, Hands
from workbench.bench.saved import save
from workbench.bench.scopes import FIRST, SCOPES
from workbench.bench.stable import stable_range
from workbench.bench.sweep_panel import SweepPanel
from workbench.errors import UserError

TEMPLATE = Path(__file__).with_name("page.html")

STATE = "state"
"""Of the address: what was turned."""

NOWHERE = (0.0, 0.0)
"""Between these places a loop is stable that is not stable as it is."""

_ADDRESS = "history.replaceState(null, '', cb_obj.text ? `?state=${cb_obj.text}` : location.pathname)"


_DARK = "document.documentElement.dataset.theme = cb_obj.active ? 'dark' : 'light'"


class BenchPage:
    """The bench in one tab of a browser: a loop at hand, and one that is pinned beside it."""

    def __init__(
        self, document: Document, loop: BenchLoop, folder: Path, state: str = "", beside: BenchLoop | None = None
    ) -> None:
        self._document, self._folder, self._first = document, folder, loop
        self._pinned = None if beside is None else outcome_of(beside)
        self._change: dict[str, object] = {}
        self._workers = ThreadPoolExecutor(1)
        self._moves = 0
        self._offered: list[str] = []
        self._scopes = {name: ScopeFigure(name) for name in FIRST}
        self._pace = Pace(document, self._run_change, self._take_time)
        self._panel = ControlPanel(
            groups_of(loop), Hands(self._turned, self._chosen, self._flipped, self._tell), self._show_controls
        )
        self._sweep = SweepPanel(document, lambda: self._here.loop, lambda: self._panel.knobs, self._go)
        self._message = Div(text="", visible=False, stylesheets=[WIDGETS], sizing_mode="stretch_width", name="message")
        self._table = Div(text="", sizing_mode="stretch_width", stylesheets=[WIDGETS], name="figures")
        self._address = Div(text="", visible=False, name="address")
        self._address.js_on_change("text", CustomJS(code=_ADDRESS))
        self._grid = row(Div(), sizing_mode="stretch_width", name="grid", styles={"flex-wrap": "wrap"})
        self._build()
        self._here = outcome_of(loop)
        self._open_with(state)
        document.on_session_destroyed(lambda _context: self._workers.shutdown(wait=False, cancel_futures=True))

    def _open_with(self, state: str) -> None:
        trouble = ""
        if state:
            try:
                self._here = outcome_of(decoded(state, self._first))
            except UserError as error:
                trouble = str(error)
        self._show_run()
        self._lay_out()
        self._show_controls()
        self._tell(trouble)

    # -- building ------------------------------------------------------------------------------------------------------

    def _build(self) -> None:
        document = self._document
        document.add_root(self._actions())
        document.add_root(self._panel.layout)
        words = row(self._pace.words, self._address)
        document.add_root(column(self._message, self._table, words, sizing_mode="stretch_width", name="results"))
        self._choose = CheckboxButtonGroup(
            stylesheets=[WIDGETS, WRAPPED], name="choose_scopes", sizing_mode="stretch_width"
        )
        self._choose.on_change("active", lambda _attr, _old, new: self._open([self._offered[i] for i in new]))
        document.add_root(column(self._choose, self._grid, sizing_mode="stretch_width", name="scopes"))
        document.add_root(self._sweep.layout)
        document.template = Template(TEMPLATE.read_text(encoding="utf-8"))
        document.template_variables["bench_title"] = str(self._first.content.get("title", "bench"))
        document.title = "Friction Workbench"

    def _actions(self) -> Any:
        def button(label: str, name: str, act: Any) -> Button:
            made = Button(label=label, name=name, stylesheets=[WIDGETS])
            made.on_click(act)
            return made

        self._name = TextInput(placeholder="my_study.toml", name="save_name", width=150, stylesheets=[WIDGETS])
        self._replace = Checkbox(label="replace", name="save_replace", stylesheets=[WIDGETS], margin=(10, 5, 5, 5))
        dark = Toggle(label="Dark", name="dark", stylesheets=[WIDGETS])
        dark.js_on_change("active", CustomJS(code=_DARK))
        dark.on_change("active", lambda _attr, _old, on: self._darken(bool(on)))
        return row(
            button("Pin", "pin", lambda: self._pin(self._here)),
            button("Swap with pinned", "swap", self._swap),
            button("Unpin", "unpin", lambda: self._pin(None)),
            button("As opened", "reset", lambda: self._put(self._first)),
            self._name,
            self._replace,
            button("Save as study", "save", self._save),
            dark,
            name="actions",
            styles={"flex-wrap": "wrap"},
        )

    def _lay_out(self) -> None:
        self._grid.children = [scope.figure for scope in self._scopes.values()] or [Div()]

    def _offer_scopes(self) -> None:
        """Those that show something of this plant, and those that are open."""
        self._offered = [name for name in SCOPES if name in self._scopes or SCOPES[name].view(self._here).curves]
        labels, active = [SCOPES[name].title for name in self._offered], list(map(self._offered.index, self._scopes))
        if self._choose.labels != labels:
            self._choose.update(labels=labels, active=active)

    def _open(self, names: Sequence[str]) -> None:
        if list(names) == list(self._scopes):
            return
        self._scopes = {name: self._scopes.get(name) or ScopeFigure(name) for name in SCOPES if name in names}
        self._show_run()
        self._lay_out()

    # -- what the hand does --------------------------------------------------------------------------------------------

    def _turned(self, change: Change) -> None:
        self._moves += 1
        self._change |= change
        self._pace.want()

    def _go(self, knob: Knob, value: float) -> None:
        """Take a knob to the value of a point of the sweep."""
        self._turned(knob.change(value))

    def _chosen(self, key: str, name: str) -> None:
        loop = chosen(self._here.loop, key, name)
        if loop is not None:  # none that does not serve is offered
            self._put(loop)

    def _flipped(self, change: Change) -> None:
        self._put(self._here.loop.changed(change))

    def _run_change(self) -> None:
        change, self._change = self._change, {}
        if self._run(self._here.loop.changed(change)) and not self._panel.refresh(change):
            self._show_controls()

    def _put(self, loop: BenchLoop) -> None:
        """Put another loop on the bench, with controls of its own."""
        self._moves += 1
        if self._run(loop):
            self._show_controls()

    def _run(self, loop: BenchLoop) -> bool:
        """Run a loop and show it; one that cannot be run is told, and the last one stays."""
        try:
            self._here = outcome_of(loop)
        except UserError as error:
            self._tell(str(error).removeprefix(f"{loop.study.path}: "))
            self._panel.restore()
            self._pace.sent()
            return False
        self._show_run()
        return True

    def _pin(self, outcome: Outcome | None) -> None:
        self._pinned = outcome
        self._show_run()

    def _swap(self) -> None:
        if self._pinned is not None:
            self._here, self._pinned = self._pinned, self._here
            self._show_run()
            self._show_controls()

    def _save(self) -> None:
        try:
            path = save(self._here, self._name.value, self._folder, replace=self._replace.active)
        except (UserError, OSError) as error:
            self._tell(str(error))
            return
        command = f"workbench run {path.relative_to(self._folder.resolve())} --out results/{path.stem}"
        self._tell(f"saved; the same figures come out of: {command}", good=True)

    # -- what is seen --------------------------------------------------------------------------------------------------

    def _show_run(self) -> None:
        self._document.hold("combine")
        self._tell("")
        for scope in self._scopes.values():
            scope.show(self._here, self._pinned)
        self._table.text = figures_table(self._here, self._pinned)
        self._pace.sent()
        self._document.unhold()

    def _show_controls(self) -> None:
        self._offer_scopes()
        self._panel.show(self._here)
        self._sweep.offer(self._here)
        self._pace.rest()

    def _tell(self, words: str, *, good: bool = False) -> None:
        colour = "--strong" if good else "--bad"
        text = f'<p style="color: var({colour}); margin: 0">{escape(words)}</p>' if words else ""
        if self._message.text != text:
            self._message.update(text=text, visible=bool(text))

    def _darken(self, on: bool) -> None:
        self._document.theme = "dark_minimal" if on else "light_minimal"

    # -- what takes longer ---------------------------------------------------------------------------------------------

    def _take_time(self) -> None:
        """Nothing moves: write the state into the address, and find where the margins end."""
        self._address.text = encoded(self._here.loop, self._first)
        if self._panel.group == "controller":
            self._workers.submit(self._find_margins, self._here, self._panel.knobs, self._moves)

    def _find_margins(self, here: Outcome, knobs: Sequence[Knob], moves: int) -> None:
        """In a thread of its own; the next movement ends it."""
        for knob in knobs:
            found = stable_range(here, knob, lambda: self._moves != moves)
            if self._moves != moves:
                return
            self._document.add_next_tick_callback(self._marking(knob.key, found or NOWHERE))

    def _marking(self, key: str, found: tuple[float, float]) -> Any:
        return lambda: self._panel.mark(key, *found)
