"""A cylinder with a pressure in each chamber at rest under a constant load."""

from collections.abc import Callable
from typing import Any, NamedTuple

from plants.rising import zeros


class Resting(NamedTuple):
    """What an equilibrium is found between: areas (m^2), the pressures of tank and supply (Pa), the spool's way (m)."""

    area_1: float
    area_2: float
    tank: float
    supply: float
    spool_limit: float


def at_rest(
    net_flows: Callable[..., tuple[float, float]], p: Any, between: Resting, total: float
) -> tuple[float, float, float]:
    """Both pressures (Pa) and the spool (m) of a machine at rest: P1 A1 - P2 A2 = F_load.

    A closed valve leaves one pressure open: there P1 + P2 = `total`, as far as tank and supply allow; a load beyond
    what they hold gets the pressures that hold the most of it. Where fluid leaks, past the piston or across edges that
    are open at rest, the spool stands where it makes that good.

    Args:
        net_flows: (spool, P1, P2, parameters) -> flow into chamber 1 and out of chamber 2; rise with the spool.
        p: parameters of the machine, with its `body`.
        between: areas and limits.
        total: sum of both pressures (Pa) behind a valve that lets nothing through.
    """
    load = p.body.load_force

    def other(pressure_1: float) -> float:
        return float((pressure_1 * between.area_1 - load) / between.area_2)

    def spools_for(chamber: int, pressure_1: float) -> tuple[float, float]:
        """From where to where the spool may be: edges that are closed let nothing through over a whole way."""

        def flow(spool: float) -> float:
            return float(net_flows(spool, pressure_1, other(pressure_1), p)[chamber])

        return zeros(flow, -between.spool_limit, between.spool_limit)

    def apart(pressure_1: float) -> float:
        """By how much the spool that chamber 1 asks for is beyond what chamber 2 asks for; 0 where one serves both."""
        (low_1, high_1), (low_2, high_2) = spools_for(0, pressure_1), spools_for(1, pressure_1)
        return max(low_1 - high_2, 0.0) + min(high_1 - low_2, 0.0)

    least = max(between.tank, (load + between.tank * between.area_2) / between.area_1)
    most = min(between.supply, (load + between.supply * between.area_2) / between.area_1)
    if least > most:
        ends = (between.supply, between.tank) if load > 0.0 else (between.tank, between.supply)
        return *ends, 0.0
    pressure_1 = (load + total * between.area_2) / (between.area_1 + between.area_2)
    pressure_1 = min(max(pressure_1, least), most)
    if all(abs(flow) == 0.0 for flow in net_flows(0.0, pressure_1, other(pressure_1), p)):
        return pressure_1, other(pressure_1), 0.0
    lowest, highest = zeros(apart, least, most)
    pressure_1 = min(max(pressure_1, lowest), highest)
    (low_1, high_1), (low_2, high_2) = spools_for(0, pressure_1), spools_for(1, pressure_1)
    low, high = max(low_1, low_2), min(high_1, high_2)
    return pressure_1, other(pressure_1), max(low, min(high, 0.0))
