"""What a record's clock allows: stamps in order, pieces without gaps, an even grid, and what can be seen on it."""
