"""Every plant with every controller and every friction law, pair by pair: refused in a line, or it runs."""

from pathlib import Path

import numpy as np
import pytest
from combinations import Machine, machines, pairwise, resolved, stepped

from workbench.errors import UserError

TRIED = [item for item in machines() if item.bristle in ("", "isotropic") and item.rotation == "servo"]


@pytest.mark.parametrize(("place", "machine"), list(enumerate(TRIED)), ids=[item.name for item in TRIED])
def test_what_is_not_refused_in_a_line_runs(place: int, machine: Machine, tmp_path: Path) -> None:
    accepted = 0
    for one in pairwise(machine, place):
        refusal = ""
        try:
            item = resolved(one, tmp_path, 0.2)
        except UserError as error:
            refusal = str(error)
        assert "\n" not in refusal, one
        if not refusal:
            assert np.all(np.isfinite(stepped(item))), one
            accepted += 1
    assert accepted > 3, "a machine that hardly any controller serves is none"
