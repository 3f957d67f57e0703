"""Friction laws as objects: any plant takes any of them."""
