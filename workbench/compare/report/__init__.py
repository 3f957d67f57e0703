"""A finished comparison as a page, tables and figures."""
