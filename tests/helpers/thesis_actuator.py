"""What the thesis's actuator has not, and other plants need beside its parameters."""

FORCE_GAIN = {"force_gain": 100.0, "pump_displacement": 2e-7}
"""N/V and m^3/rad: a drive that a voltage moves and a pump need them."""
