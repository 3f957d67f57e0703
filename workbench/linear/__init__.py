"""Plants and loops for linear analysis: Jacobians, operating points, margins, describing functions."""
