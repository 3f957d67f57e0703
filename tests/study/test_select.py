"""Rows of results that conditions pick."""

import numpy as np
import pandas as pd

from workbench.study.names import matches
from workbench.study.report.select import rows


def test_rows_are_picked_as_matches_picks_cases() -> None:
    """Numbers as numbers however they are written, text as text, what is missing by no number."""
    values = [0, "460", 460.0, None, float("nan"), "a", True, "[1, 2]"]
    for column in (pd.Series(values, dtype=object), pd.Series([0.0, 460.0, float("nan")]), pd.Series([0, 1, 460])):
        frame = pd.DataFrame({"x": column, "outcome": "completed"})
        for asked in (0, "0", 460, "460 ", "460.0", "a", "b", "None", True, [1, 2]):
            expected = [matches({"x": value}, {"x": asked}) for value in frame["x"]]
            assert rows(frame, {"x": asked}).index.tolist() == np.flatnonzero(expected).tolist(), asked
    assert len(rows(frame, {})) == len(frame)
