"""What `benchmarks/all.py` measures: a file a part, each of which ends as a table, a figure and some ratios."""
