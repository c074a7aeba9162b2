"""The plants of the recipes: a model and an experiment in each file."""
