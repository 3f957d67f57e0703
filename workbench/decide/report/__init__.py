"""A finished decision as a page, tables and figures."""
