"""A closed loop of the thesis's actuator that is over in no time."""

import workbench as wb


def small(**changes: object) -> wb.LoopSetup:
    """A short run of the standing rod, with changes of it."""
    options = {"controller": wb.pid(kp=500), "reference": wb.sine("5 mm", "2 Hz"), "duration": "0.5 s", **changes}
    return wb.setup("non_rotating", "owen2001_simulation", **options)
