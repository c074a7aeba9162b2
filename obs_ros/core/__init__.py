"""What everything rests on: models, records, estimates, registries, compiled loops."""
