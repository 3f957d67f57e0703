"""What a machine may have beyond a plant's equations: one physical term each, neutral at its default."""
