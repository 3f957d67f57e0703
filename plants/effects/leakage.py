"""Leaks of oil and of air: parameters that the plants have themselves, in their continuity and in their equilibrium.

No leak lets through more than the valve at full travel at supply pressure: the machine would not move.
"""

from plants.effects.interface import Effect, Number
from plants.effects.scales import conductance

INTERNAL_LEAKAGE = Effect(
    name="internal_leakage",
    balance="flow",
    words="oil leaks from one chamber into the other",
    source="Merritt 1967",
    numbers={"leakage_coefficient": Number(0.0, 1.0, 0.001, conductance)},
    needs=("pressure_1",),
)
"""C (P1 - P2). An external leak of both chambers looks alike where the pressures' sum is constant."""

INTERNAL_AIR_LEAKAGE = Effect(
    name="internal_air_leakage",
    balance="flow",
    words="air leaks from one chamber into the other",
    source="ISO 6358; Beater 2007",
    numbers={"leakage_conductance": Number(0.0, 1.0, 0.001, conductance)},
    needs=("pressure_1",),
)
"""The flow through an opening with the sonic conductance C, from the higher pressure to the lower."""

EXTERNAL_LEAKAGE = Effect(
    name="external_leakage",
    balance="flow",
    words="a chamber leaks to the outside",
    source="Merritt 1967",
    numbers={
        "external_leakage_1": Number(0.0, 1.0, 0.001, conductance),
        "external_leakage_2": Number(0.0, 1.0, 0.001, conductance),
    },
    apart=(("external_leakage_1",), ("external_leakage_2",), ("external_leakage_1", "external_leakage_2")),
    needs=("pressure_1", "pressure_2"),
)
"""C (P - P_tank) of oil, a sonic conductance to the atmosphere of air: m^3/(s Pa) of either. Leaks of one chamber look
like an internal leak where the other's pressure hardly moves; where a load moves both they differ in the sum.
"""
