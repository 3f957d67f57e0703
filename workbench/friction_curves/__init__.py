"""Measured friction-velocity curves against what the bristle laws predict of them."""
