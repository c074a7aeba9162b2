"""Many runs: recordings by settings, or Monte Carlo, in this process, in several, or on Dask."""
