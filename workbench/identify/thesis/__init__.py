"""The thesis's method: friction from slow records, direction by direction."""
