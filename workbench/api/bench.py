"""The bench in a notebook, or beside a script: a loop with sliders and scopes, as a page of this machine."""

from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.api.loops import A_LOOP, LoopSetup
from workbench.api.plain import expect
from workbench.bench.loop import loop_of

if TYPE_CHECKING:
    from workbench.bench.server import BenchServer


class Bench:
    """A bench that is served as long as the program runs, or until `close`; in a notebook it shows itself in the cell.

    Example:
        >>> loop = wb.setup("non_rotating", "owen2001_simulation", controller=wb.pid(kp=500))
        >>> bench = wb.bench(loop, height=600)
        >>> bench.url in bench._repr_html_()
        True
        >>> bench.close()
    """

    def __init__(self, server: "BenchServer", height: int) -> None:
        self._server, self._height = server, height

    @property
    def url(self) -> str:
        """Where it is, on this machine alone, with the token without which nothing is found."""
        return self._server.url

    def close(self) -> None:
        """End it."""
        self._server.stop()

    def __repr__(self) -> str:
        return f"Bench({self.url})"

    def _repr_html_(self) -> str:
        frame = f'width="100%" height="{self._height}" style="border: 1px solid #ccc"'
        return f'<iframe src="{escape(self.url)}" title="bench" {frame}></iframe>'


def bench(setup: LoopSetup, *, folder: str | Path = ".", port: int = 0, height: int = 900) -> Bench:
    """Put a loop on the bench: its parameters as sliders, and scopes that follow the hand.

    Args:
        setup: of `setup` or `Study.setup`.
        folder: where studies are saved.
        port: on this machine; 0 for any that is free.
        height: of the frame in a notebook, in pixels.

    Raises:
        UserError: it is something else, or the port is taken.

    Example:
        >>> loop = wb.setup("rotating", "owen2001_simulation", rpm=120, controller=wb.pid(kp=500),
        ...                 reference=wb.sine("30 mm", "0.9 Hz"))
        >>> bench = wb.bench(loop)
        >>> bench.url.startswith("http://127.0.0.1:")
        True
        >>> bench.close()
    """
    from workbench.bench.serving import bench_server

    expect(setup, LoopSetup, "bench", A_LOOP)
    server = bench_server(loop_of(setup.study, setup.case), Path(folder), port)
    server.start_beside()
    return Bench(server, height)
