"""A finished tuning as a page, tables and figures."""
