"""Integration methods as objects: each an explicit Runge-Kutta scheme, written as its tableau."""
