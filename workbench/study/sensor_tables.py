"""[sensors]: what may stand there, and the sensors that it becomes."""

from plants.equation import fields
from plants.interface import SENSORS, Measurement
from workbench.simulation.sensors import Channel, Sensors
from workbench.study.schema import ChannelTable, SensorsTable
from workbench.toml.reading import SchemaError
from workbench.toml.units import QuantityError, si


def build_sensors(table: SensorsTable) -> Sensors:
    """The sensors that a table describes, in SI; what it does not say is ideal.

    Raises:
        SchemaError: a setting of the wrong unit, or an impossible one.
    """
    channels = {}
    for item in fields(Measurement):
        if item.name not in SENSORS:
            continue
        channel: ChannelTable = getattr(table, item.name)
        resolution = _value(channel, "resolution", item.name, item.unit)
        if channel.bits is not None:
            resolution = _value(channel, "range", item.name, item.unit) / 2**channel.bits
        travel = _value(channel, "calibration_travel", item.name, item.unit)
        if channel.calibration_error is not None and travel == 0.0:
            raise SchemaError(("sensors", item.name, "calibration_travel"), "got 0, expected a value above 0")
        channels[item.name] = Channel(
            _value(channel, "noise", item.name, item.unit),
            resolution,
            channel.anti_alias,
            _value(channel, "offset", item.name, item.unit, signed=True),
            channel.gain_error,
            _value(channel, "calibration_error", item.name, item.unit),
            travel,
            channel.calibration_seed,
        )
    return Sensors(channels, table.delay)


def _value(table: ChannelTable, name: str, channel: str, unit: str, *, signed: bool = False) -> float:
    """A setting of a sensor in SI, 0 where nothing is said."""
    value, key = getattr(table, name), ("sensors", channel, name)
    try:
        number = si(value or 0.0, unit)
    except QuantityError as error:
        raise SchemaError(key, str(error)) from None
    if number < 0.0 and not signed:
        raise SchemaError(key, f"got {value!r}, expected a value that is not negative")
    return number
