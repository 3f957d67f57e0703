"""A design as files: reference, study, page, tables, figures."""
