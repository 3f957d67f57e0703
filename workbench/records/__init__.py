"""Measured data in: experiment files, channels, formats, checks, and what a record shows before any fit."""
