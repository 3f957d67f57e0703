"""Whether designed motions decide what first records left open, on machines of the diagnosis suite's generator."""
