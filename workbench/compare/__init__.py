"""Compensation against avoidance: verdicts with intervals out of plant samples, their words, figures and page."""
