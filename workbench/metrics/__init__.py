"""The figures of a finished run: what a row of results.csv says of it; `workbench list columns` has their meaning.

The window is t >= transient; where the reference repeats, the last whole number of its periods in there.
A dwell is a span in which the reference is constant; those that end after the transient count. A figure that does not
apply is None, never 0.
"""
