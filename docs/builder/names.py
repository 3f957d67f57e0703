"""The lists of `workbench list`: what a study may name, and the effects that a diagnosis knows."""

from pathlib import Path

from workbench.catalogue import CATALOGUE

HEADINGS = {
    "plants": "Plants",
    "friction_laws": "Friction laws",
    "controllers": "Controllers and their settings",
    "parameters": "Parameter sets",
    "machines": "Machines",
    "scenarios": "Scenarios",
    "references": "References",
    "effects": "Effects",
    "integrators": "Integration methods",
    "formats": "Formats of records",
    "columns": "Columns of the results",
}


def page(folder: Path) -> str:
    """All lists, each as the command prints it."""
    parts = ["# Names", "What files may name, as `workbench list` prints it. Plug-ins add theirs there."]
    for kind, lines in CATALOGUE.items():
        text = "\n".join(lines())
        parts += [f"## {HEADINGS[kind]}", f"```text\n{text}\n```"]
    return "\n\n".join(parts) + "\n"
