"""A first experiment file out of logs that nobody has described: what their columns are, by names and by numbers."""
