"""Compensation against avoidance: verdicts with intervals out of a study's draws, their words, figures and page."""
