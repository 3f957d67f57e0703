"""MAT files of MATLAB."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from workbench.records.formats.interface import RecordFormat

if TYPE_CHECKING:
    import pandas as pd


def read(path: Path) -> "pd.DataFrame":
    """All vectors of a MAT file (to version 7.2) that are as long as its longest."""
    import pandas as pd
    from scipy.io import loadmat

    content = {name: np.ravel(value) for name, value in loadmat(path).items() if not name.startswith("__")}
    numeric = {name: value for name, value in content.items() if value.dtype.kind in "iuf" and value.size > 1}
    longest = max((value.size for value in numeric.values()), default=0)
    return pd.DataFrame({name: value for name, value in numeric.items() if value.size == longest})


MAT = RecordFormat("mat", "MATLAB, to version 7.2: all vectors as long as the longest", (".mat",), read)
