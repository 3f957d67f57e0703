"""Models of machines that a study names and that are no plant's own name."""

MODELS = ("by_rpm", "non_rotating", "rotating", "drive")
"""Models of [plant] that stand for several plants; any registered plant's own name serves too.

`by_rpm` is the thesis's actuator whose rod turns where rpm is not 0, as any machine's does that is `turned`; that of
`rotating` always turns."""
