"""Formats of records as objects: each a way to read a table out of a file."""
