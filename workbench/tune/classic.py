"""Takes the place of what is made elsewhere."""

from typing import Any, NamedTuple


class StartingPoint(NamedTuple):
    name: str
    method: str
    settings: dict[str, float]
    note: str


def starting_points(resolved: Any) -> list[StartingPoint]:
    return [
        StartingPoint("pole_placement_pd", "pole placement", {"kp": 700.0, "kd": 4.0}, "damping 0.7"),
        StartingPoint("lqr_pd", "LQR", {"kp": 900.0, "kd": 6.0}, "Bryson weights"),
    ]
