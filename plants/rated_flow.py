"""The rated flow of a valve's data sheet, in the place of a flow gain."""

from typing import Annotated, NamedTuple

import numpy as np


class RatedFlow(NamedTuple):
    """What a data sheet says of a valve in the place of a flow gain: the flow at full travel, and the pressure drop at
    which it holds, over one edge: half of that over both.
    """

    rated_flow: Annotated[float, "m^3/s"]
    rated_edge_drop: Annotated[float, "Pa"]


def flow_gain(rated: RatedFlow, travel: float) -> float:
    """K (m^2/(s Pa^0.5)) = Q_r / (x_max sqrt(dp)) of an edge that is open by its whole `travel` (m)."""
    return float(rated.rated_flow / (travel * np.sqrt(rated.rated_edge_drop)))
