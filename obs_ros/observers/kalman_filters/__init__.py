"""Kalman filters on states and parameters together."""
