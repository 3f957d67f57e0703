"""The effects by name: on which balance each shows, by which parameters it acts, and what it is in words."""

from dataclasses import dataclass
from typing import NamedTuple

FREE = 1e300
"""No bound."""


class Number(NamedTuple):
    """Between which values (SI) a parameter of an effect may lie, and a `size` that is felt: where a search starts; 0
    for one that starts from the declared value of the other direction.
    """

    low: float
    high: float
    size: float


@dataclass(frozen=True, kw_only=True)
class Effect:
    """An effect: the balance on which it shows, and the parameters by which it acts.

    `words` say what it is to a reader who does not know its name. `numbers` are its parameters by canonical name, and
    `apart` the sets of them that may act alone, the smallest first: all together where none are given. `needs` are the
    channels without which it cannot be told, `acts_on` the signals over which it shows beyond those that are always
    looked at. A `circular` one is made of what it is to explain: the pressure carries every force that is not known.
    """

    name: str
    balance: str
    words: str
    source: str
    numbers: dict[str, Number]
    apart: tuple[tuple[str, ...], ...] = ()
    needs: tuple[str, ...] = ()
    acts_on: tuple[str, ...] = ()
    circular: bool = False

    @property
    def variants(self) -> tuple[tuple[str, ...], ...]:
        """The sets of its parameters that may act, the smallest first."""
        return self.apart or (tuple(self.numbers),)

    @property
    def signed(self) -> tuple[str, ...]:
        """Its parameters that may have either sign."""
        return tuple(name for name, number in self.numbers.items() if number.low < 0.0)


_ALL = (
    Effect(
        name="direction_asymmetry",
        balance="force",
        words="friction differs between the two directions",
        source="Owen 2001, tables 5.2 and 5.3",
        numbers={
            "coulomb_negative": Number(0.0, FREE, 0.0),
            "stribeck_negative": Number(0.0, FREE, 0.0),
            "viscous_negative": Number(0.0, FREE, 0.0),
        },
        apart=(
            ("coulomb_negative",),
            ("viscous_negative",),
            ("coulomb_negative", "stribeck_negative"),
            ("coulomb_negative", "viscous_negative"),
            ("coulomb_negative", "stribeck_negative", "viscous_negative"),
        ),
    ),
    Effect(
        name="position_dependent_friction",
        balance="force",
        words="friction changes along the stroke",
        source="Bonchis, Corke and Rye 1999",
        numbers={
            "friction_gradient": Number(-0.9, 0.9, 0.05),
            "friction_curvature": Number(-0.9, 5.0, 0.05),
        },
        apart=(
            ("friction_gradient",),
            ("friction_curvature",),
            ("friction_gradient", "friction_curvature"),
        ),
        needs=("position",),
    ),
    Effect(
        name="pressure_dependent_friction",
        balance="force",
        words="friction grows with the load pressure, as of a seal that is pressed by it",
        source="Bonchis, Corke and Rye 1999",
        numbers={
            "friction_per_pressure": Number(0.0, 0.01, 2e-05),
        },
        needs=("pressure_1",),
        circular=True,
    ),
    Effect(
        name="frictional_memory",
        balance="force",
        words="friction follows the velocity late",
        source="Hess and Soom 1990",
        numbers={
            "memory_time": Number(0.0, 0.5, 0.005),
        },
        acts_on=("acceleration",),
    ),
    Effect(
        name="rising_static_friction",
        balance="force",
        words="break-away friction grows with the time at rest",
        source="Armstrong-Helouvry, Dupont and Canudas de Wit 1994; Dieterich 1979",
        numbers={
            "static_rise": Number(0.0, 10.0, 0.2),
            "static_rise_time": Number(0.0, FREE, 0.0),
            "static_rise_distance": Number(0.0, FREE, 0.0),
        },
        apart=(
            ("static_rise",),
            ("static_rise", "static_rise_time"),
            ("static_rise", "static_rise_distance"),
            ("static_rise", "static_rise_time", "static_rise_distance"),
        ),
    ),
    Effect(
        name="quadratic_drag",
        balance="force",
        words="a resistance grows with the square of the velocity",
        source="Merritt 1967",
        numbers={
            "drag_coefficient": Number(0.0, 10000000.0, 1000.0),
        },
    ),
    Effect(
        name="viscous_drift",
        balance="force",
        words="viscous friction changes along the record, as of oil that warms up",
        source="oil that warms up",
        numbers={
            "viscous_drift": Number(-0.02, 0.2, 0.001),
        },
    ),
    Effect(
        name="constant_load",
        balance="force",
        words="a constant force acts on the rod",
        source="thesis (3.29)",
        numbers={
            "load_force": Number(-100000.0, 100000.0, 10.0),
        },
    ),
    Effect(
        name="spring_load",
        balance="force",
        words="a force grows with the position, as of a hose or cable that bends",
        source="hoses and cables",
        numbers={
            "spring_stiffness": Number(-10000000.0, 10000000.0, 1000.0),
        },
        needs=("position",),
    ),
    Effect(
        name="rotation_periodic_force",
        balance="force",
        words="a force repeats with every turn of the rod",
        source="a bent rod",
        numbers={
            "cosine_force": Number(-100000.0, 100000.0, 5.0),
            "sine_force": Number(-100000.0, 100000.0, 5.0),
        },
        needs=("rotation_angle",),
    ),
    Effect(
        name="valve_deadband",
        balance="flow",
        words="the spool has to move by its overlap before oil flows",
        source="Merritt 1967",
        numbers={
            "valve_overlap": Number(0.0, 0.0002, 2e-06),
        },
        needs=("valve_voltage",),
    ),
    Effect(
        name="internal_leakage",
        balance="flow",
        words="oil leaks from one chamber into the other",
        source="Merritt 1967",
        numbers={
            "leakage_coefficient": Number(0.0, 1e-09, 1e-13),
        },
        needs=("pressure_1",),
    ),
    Effect(
        name="supply_droop",
        balance="flow",
        words="the supply pressure falls when much oil is taken",
        source="Merritt 1967",
        numbers={
            "droop_resistance": Number(0.0, 100000000000.0, 100000000.0),
        },
        needs=("valve_voltage",),
    ),
    Effect(
        name="entrained_air",
        balance="flow",
        words="air makes the oil soft at low pressure",
        source="Merritt 1967",
        numbers={
            "air_fraction": Number(0.0, 0.2, 0.001),
        },
        needs=("pressure_1", "pressure_2"),
        acts_on=("pressure_1", "pressure_2"),
    ),
    Effect(
        name="unequal_areas",
        balance="flow",
        words="the second chamber's piston area is not the declared one",
        source="conservation of volume",
        numbers={
            "area_ratio": Number(0.2, 2.0, 0.97),
        },
    ),
    Effect(
        name="command_delay",
        balance="valve",
        words="the valve gets its command late",
        source="converters and networks",
        numbers={
            "command_delay": Number(0.0, 0.1, 0.001),
        },
        needs=("valve_voltage",),
    ),
    Effect(
        name="backlash",
        balance="sensor",
        words="the position sensor is coupled loosely to the rod",
        source="Nordin and Gutman 2002",
        numbers={
            "backlash_width": Number(0.0, 0.002, 1e-05),
        },
        needs=("position",),
    ),
    Effect(
        name="pressure_sensor_offset",
        balance="sensor",
        words="the first pressure sensor is off by a constant",
        source="zero of a transducer",
        numbers={
            "pressure_1_offset": Number(-1000000.0, 1000000.0, 5000.0),
        },
        needs=("pressure_1", "pressure_2"),
        acts_on=("pressure_1",),
    ),
)


EFFECTS = {effect.name: effect for effect in _ALL}
