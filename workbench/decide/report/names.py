"""How the page of a decision names and shows things: kinds, candidates, limits, numbers with their units."""

from workbench.decide.candidate import CandidateResult, Kind
from workbench.decide.result import Decision
from workbench.decide.schema import DecideTable
from workbench.metrics.statistics import SURE
from workbench.publish.tables import shown_number
from workbench.publish.words import plain_name

MM = 1e3

TOLD_SPEED = 0.02
"""A real speed of rotation is told where it differs from the command by more than this share."""

NAMES: dict[Kind | None, str] = {
    "plain": "plain control",
    "compensation": "compensation",
    "rotation": "rotation",
    "both": "rotation with compensation",
    None: "nothing",
}

SHORT: dict[Kind, str] = {
    "plain": "plain",
    "compensation": "compensation",
    "rotation": "rotation",
    "both": "rotation and compensation",
}

ERRORS = {"rms_error": "rms error", "max_error": "largest error"}
POWERS = {
    "paid": "paid: the pump's, plus that of the motor's terminals",
    "electric": "at the piston, plus that of the motor's terminals",
    "total": "at the piston, plus that of the rotary friction",
}


def choice(row: CandidateResult) -> str:
    """A candidate in words."""
    if not row.rpm:
        return f"{plain_name(row.controller)} without rotation"
    told = abs(row.real_rpm / row.rpm - 1.0) > TOLD_SPEED
    return f"{plain_name(row.controller)} at {row.rpm:g} rpm{f' (really {row.real_rpm:.3g} rpm)' * told}"


def millimetres(value: float) -> str:
    """A length (m) as shown."""
    return f"{shown_number(value * MM, 3)} mm"


def watts(value: float) -> str:
    """A power (W) as shown."""
    return f"{shown_number(value, 3)} W"


def speed_of(value: float) -> str:
    """A speed (m/s) as shown."""
    return f"{value * MM:g} mm/s"


def deviations(spread: float) -> str:
    """A spread of friction as shown."""
    return f"{spread:g} standard deviation{'s' * (spread != 1.0)}"


def where(decision: Decision) -> str:
    """The speed and spread that were asked for."""
    return f"at {speed_of(decision.table.speed)}, friction spread by {deviations(decision.table.spread)}"


def percent(table: DecideTable) -> str:
    """The probability that is asked for, as the share of a quantile."""
    return f"{100.0 * table.probability:g} %"


def share(value: float) -> str:
    """A probability as shown."""
    return f"{value:.3f}" if 0.0 < value < 1.0 else f"{value:g}"


def interval(row: CandidateResult) -> str:
    """The interval of a probability."""
    return f"{share(row.low)} to {share(row.high)}"


def confidence() -> str:
    """That of all intervals together."""
    return f"{100.0 * SURE:g} %"


def machines(row: CandidateResult) -> str:
    """On how many machines of which draws."""
    return f"{row.met} of {row.draws} {'fresh machines' if row.stage == 'fresh' else 'machines of the search'}"
