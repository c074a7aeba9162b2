"""From a fit to an estimate: what is determined, deviations, tests, outcome, advice."""
