"""True plants to try estimators on: scenarios of the papers, noise, faults, a simulator node."""
