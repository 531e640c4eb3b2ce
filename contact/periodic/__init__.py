"""Motions that repeat, and the way to them."""
