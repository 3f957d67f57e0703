"""A continuous plant in the loop with a sampled controller."""
