"""Inference from one window: objective, prior, noise, jumps, and the uncertainty of each number."""
