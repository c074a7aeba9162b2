"""A whole population of candidates through a window: compiled where Numba is, else on NumPy."""
