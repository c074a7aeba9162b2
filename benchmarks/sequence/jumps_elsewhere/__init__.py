"""Jumps, and what is none, on plants that nobody has tuned to."""
