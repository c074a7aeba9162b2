"""Plant and estimator side by side: whoever is ahead waits for the other."""


def runs_on(running: bool, plant: float, newest: float, window: float, period: float) -> bool:
    """Return whether the plant, now at time `plant` (s), is to run.

    It stops once it, or the `newest` verdict (s), is two periods (s) ahead of the other, and goes
    on within one. The first verdict comes after a whole `window` (s).
    """
    lag = abs(plant - max(newest, min(plant, window)))
    return lag <= (2.0 if running else 1.0) * period
