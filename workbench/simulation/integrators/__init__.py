"""Integration methods as objects: each a Runge-Kutta scheme, explicit or linearly implicit, written as its tableau."""
