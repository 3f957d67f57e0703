"""The pace of a page: the next run begins when the browser has drawn the last one, so that none piles up."""

from collections.abc import Callable
from typing import Any

from bokeh.document import Document
from bokeh.models import ColumnDataSource, CustomJS
from bokeh.models.widgets.markups import Div

from workbench.bench.looks import WIDGETS

LOST = 1000
"""ms after which a page that did not say that it has drawn gets the next run all the same: a hidden tab draws none."""

IDLE = 400
"""ms without a movement, after which what takes longer is made."""

MOVED = "window.bench_moved ??= performance.now()"
"""What a slider says in the browser when the hand moves it."""

_DRAWN = """
requestAnimationFrame(() => requestAnimationFrame(() => {
    if (window.bench_moved !== undefined) {
        const took = performance.now() - window.bench_moved
        window.bench_times = (window.bench_times ?? []).concat(took).slice(-1000)
        window.bench_moved = undefined
        words.text = `drawn ${took.toFixed(0)} ms after the hand moved`
    }
    drawn.data = {number: sent.data.number}
}))
"""


class Pace:
    """Asks for runs one after another: `run` is called once for all that was moved since the last was drawn."""

    def __init__(self, document: Document, run: Callable[[], None], idle: Callable[[], None]) -> None:
        self._document, self._run, self._idle = document, run, idle
        self._wanted, self._busy, self._number = False, False, 0
        self._lost: Any = None
        self._later: Any = None
        self._sent, self._drawn = (ColumnDataSource(data={"number": [0]}) for _ in range(2))
        self.words = Div(text="", stylesheets=[WIDGETS], name="speed", tags=[self._sent, self._drawn])
        self._sent.js_on_change(
            "data", CustomJS(args={"sent": self._sent, "drawn": self._drawn, "words": self.words}, code=_DRAWN)
        )
        self._drawn.on_change("data", lambda _attr, _old, _new: self._is_drawn())

    def want(self) -> None:
        """There is something new to run."""
        self._wanted = True
        if not self._busy:
            self._begin()

    def sent(self) -> None:
        """A run has been sent to the browser."""
        self._number += 1
        self._sent.data = {"number": [self._number]}

    def rest(self) -> None:
        """Call `idle` once nothing has moved for a while."""
        self._later = self._replaced(self._later, self._idle_now, IDLE)

    def _begin(self) -> None:
        self._wanted, self._busy = False, True
        self._lost = self._replaced(self._lost, self._is_drawn, LOST)
        self._document.add_next_tick_callback(self._run)

    def _is_drawn(self) -> None:
        self._busy = False
        if self._wanted:
            self._begin()
        else:
            self._lost = self._replaced(self._lost, None, 0)
            self.rest()

    def _idle_now(self) -> None:
        self._later = None
        self._idle()

    def _replaced(self, timer: Any, call: Callable[[], None] | None, after: int) -> Any:
        if timer is not None and timer in self._document.session_callbacks:
            self._document.remove_timeout_callback(timer)
        return None if call is None else self._document.add_timeout_callback(call, after)
