"""Serving a loop as a bench."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.bench.loop import BenchLoop
from workbench.bench.outcome import outcome_of
from workbench.bench.page import STATE, BenchPage
from workbench.bench.server import BenchServer

if TYPE_CHECKING:
    from bokeh.document import Document


def bench_server(loop: BenchLoop, folder: Path, port: int = 0, beside: BenchLoop | None = None) -> BenchServer:
    """A server whose pages begin with this loop, and one pinned `beside` it; studies are saved in `folder`.

    Raises:
        UserError: the loop cannot be run, or the port is taken.
    """
    outcome_of(loop)  # what is wrong with it is told here; and it is compiled before somebody waits for a page

    def build(document: "Document") -> None:
        request: Any = getattr(document.session_context, "request", None)
        given = [] if request is None else request.arguments.get(STATE, [])
        BenchPage(document, loop, folder, given[0].decode("ascii", "replace") if given else "", beside)

    return BenchServer(build, port)
