"""Measurements: error beside time, against peers in the same run. `python -m benchmarks.NAME`."""
