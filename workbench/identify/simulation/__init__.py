"""Identification by simulation error, with what the fit is worth."""
