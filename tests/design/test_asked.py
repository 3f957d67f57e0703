"""[design] of an experiment: what docs/design.md shows is what the program takes."""

import tomllib

from command import ROOT

from workbench.design.schema import DesignTable
from workbench.toml.reading import conform

DOCS = (ROOT / "docs" / "design.md").read_text(encoding="utf-8")


def test_the_table_to_copy_is_in_order_and_shows_every_key() -> None:
    data = tomllib.loads(DOCS.partition("```toml\n")[2].partition("```")[0])["design"]
    table = conform(DesignTable, data)
    assert set(data) == set(DesignTable.model_fields)
    assert set(data["limits"]) == set(type(table.limits).model_fields)
    assert table.duration == 60.0
