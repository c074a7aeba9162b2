"""One window after the other: the front door, warm starts, the arrival cost, jumps announced."""
