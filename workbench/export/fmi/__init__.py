"""A plant as a Functional Mock-up Unit: its equations as C, its description as XML, in one archive."""
