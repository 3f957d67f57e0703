"""Gains found fairly: the same budget, objective and constraints for every controller."""
