"""Windows in sequence: how far their intervals and alarms can be believed, and what they cost."""
