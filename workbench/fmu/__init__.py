"""Functional Mock-up Units of others: what one says of itself, and running one in the place of a plant.

An FMU is foreign code. Reading its archive and its description runs none of it; `library` alone loads it, for a
machine that was `allowed`.
"""
