"""workbench export: what goes on outside the program: a file a form."""

import importlib

import typer

FORMS = ("controller", "plant", "linear", "notebook")
"""In the order in which help shows them; each is the function `command` of a file of its name."""

app = typer.Typer(no_args_is_help=True, rich_markup_mode=None)


@app.callback()
def _group() -> None:
    """A controller as C, a plant as an FMU, linear models, a notebook."""


for form in FORMS:
    app.command(form)(importlib.import_module(f"workbench.cli.export.{form}").command)
