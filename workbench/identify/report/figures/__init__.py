"""Figures of an identification: of each one function that makes its numbers, and one that draws them."""
