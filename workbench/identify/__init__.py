"""From records of a rig to a plant's parameters."""
