"""Effects compete for a residual; what none explains."""
