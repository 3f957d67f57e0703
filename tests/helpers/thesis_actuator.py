"""What the thesis's actuator has not, and other plants need beside its parameters."""

FORCE_GAIN = {
    "force_gain": 100.0,
    "pump_displacement": 2e-7,
    "velocity_gain": 0.05,
    "dead_band": 0.5,
    "command_delay": 0.0123,
    "axis_time_constant": 0.02,
}
"""SI: a drive that a voltage moves, a pump and a valve-driven axis need them."""
