"""A finished diagnosis as report.json, a page, tables and figures."""
