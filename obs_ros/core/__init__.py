"""The ground floor: models, records, estimates, registries, compiled loops."""
