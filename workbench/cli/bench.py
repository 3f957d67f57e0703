"""workbench bench: a loop in the browser, with sliders and scopes."""

from pathlib import Path
from typing import Annotated

import typer

from workbench.cli.options import Where, conditions


def command(
    path: Annotated[
        Path | None,
        typer.Argument(
            help="A study, a folder of results, of a diagnosis or an identification, or a parameter file.",
            metavar="[STUDY.toml | DIR | plant.toml]",
        ),
    ] = None,
    where: Where = None,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port on this machine; default: any free one.")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open a browser.")] = True,
) -> None:
    """Turn a loop's parameters in the browser and watch it."""
    from workbench.bench.opened import opened

    loop = opened(path, conditions(where))
    from workbench.bench.serving import bench_server

    server = bench_server(loop, Path.cwd(), port)
    print(f"the bench is at {server.url}", flush=True)
    print("studies are saved in this folder; Ctrl-C ends it", flush=True)
    try:
        server.run(browser=browser)
    except KeyboardInterrupt:
        print("\nended")
