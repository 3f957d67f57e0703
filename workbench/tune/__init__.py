"""Tuning: the closed loop's exact gradient by the gains of its controller, and the polish of settings by it."""
