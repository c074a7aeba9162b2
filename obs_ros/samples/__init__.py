"""A stream of samples becomes windows: merged, ordered, checked, aligned."""
