"""Windows in sequence: their intervals and alarms held against the truth, and their cost."""
