"""Tuning: the linearised loop with its stability margins, and classic starting points for the gains of a PID."""
