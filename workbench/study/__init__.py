"""Studies: a file that says what to vary, and the folder of results that it becomes."""
