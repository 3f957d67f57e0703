"""workbench bench: a loop in the browser, with sliders and scopes."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from workbench.cli.options import Where, conditions
from workbench.errors import UserError

if TYPE_CHECKING:
    from workbench.bench.loop import BenchLoop


def command(
    path: Annotated[
        Path | None,
        typer.Argument(
            help="A study, an experiment, a folder of results, of a diagnosis or an identification, or parameters.",
            metavar="[FILE.toml | DIR]",
        ),
    ] = None,
    where: Where = None,
    corrected: Annotated[
        Path | None,
        typer.Option(help="Of an experiment: a plant.toml, or the folder of a diagnosis.", metavar="DIR | plant.toml"),
    ] = None,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port on this machine; default: any free one.")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open a browser.")] = True,
) -> None:
    """Turn a loop's parameters in the browser and watch it."""
    from workbench.bench.opened import opened

    loop = opened(path, conditions(where))
    from workbench.bench.serving import bench_server

    beside = None
    if corrected is not None:
        beside, loop = loop, _corrected(loop, corrected)
    server = bench_server(loop, Path.cwd(), port, beside)
    print(f"the bench is at {server.url}", flush=True)
    print("studies are saved in this folder; Ctrl-C ends it", flush=True)
    try:
        server.run(browser=browser)
    except KeyboardInterrupt:
        print("\nended")


def _corrected(loop: "BenchLoop", path: Path) -> "BenchLoop":
    """The loop of an experiment with a plant that was found."""
    from workbench.bench.measured import MeasuredLoop, corrected

    if not isinstance(loop, MeasuredLoop):
        raise UserError("--corrected: belongs to an experiment, whose record is shown beside the corrected plant")
    return corrected(loop, path)
