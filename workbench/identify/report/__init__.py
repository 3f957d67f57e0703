"""A finished identification as files, tables and figures."""
