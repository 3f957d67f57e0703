"""A document for a paper or a thesis, of the tables, figures and words of results."""
