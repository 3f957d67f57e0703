"""Equations, recorded as the operations that they are: what compiled code, and code to be exported, is written from."""
