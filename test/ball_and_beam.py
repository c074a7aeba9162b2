"""A ball on a beam, as a user writes it: r'' = a sin(u) - b r' + c, and recordings of it."""

import math
import os
from pathlib import Path

import numpy as np
import pytest

from obs_ros import Model, Variable

RECORDING = 'ball_and_beam.csv'


def dynamics(t, x, u, p):
    _, v = x
    a, b, c = p
    return v, a * np.sin(u[0]) - b * v + c


def output(t, x, u, p):
    return (x[0],)


BALL = Model(
    name='ball_and_beam',
    states=(
        Variable('r', unit='m', lower=-1.0, upper=1.0),
        Variable('v', unit='m/s', lower=-2.0, upper=2.0),
    ),
    inputs=(Variable('u', unit='rad', interpolation='linear'),),
    outputs=(Variable('y', unit='m'),),
    parameters=(
        Variable('a', unit='m/s2', lower=0.0, upper=15.0),
        Variable('b', unit='1/s', lower=0.0, upper=5.0),
        Variable('c', unit='m/s2', lower=-1.0, upper=1.0),
    ),
    dynamics=dynamics,
    output=output,
    max_step=0.05,
)


def real_recording() -> Path:
    """Return where the recording of the real rig lies, or skip the test."""
    beside = Path(__file__).parents[2] / 'shared' / 'data'
    path = Path(os.environ.get('OBS_ROS_TEST_DATA', beside)) / RECORDING
    if not path.is_file():
        pytest.skip(f'there is no {path}; OBS_ROS_TEST_DATA names another folder')
    return path


def made_up(rows: int = 300, seed: int = 1, noise: float = 1e-4, tilted: float = math.inf):
    """Return t (K,), u (K,) and y (K,) of a rig with a = 5, b = 0.3, c = 0.1, noise in m.

    From the time `tilted` (s) on, c is -0.3.
    """
    t, u, r, _ = motion(rows, tilted)
    return t, u, r + noise * np.random.default_rng(seed).standard_normal(rows)


def motion(rows: int, tilted: float = math.inf):
    """Return t (K,) in s, u (K,) in rad, r (K,) in m and v (K,) in m/s, all without noise.

    The beam holds the ball near the middle and shakes it; between samples its angle is linear.
    """
    t = 0.1 * np.arange(rows)
    shake = 0.15 * np.sin(1.7 * t) + 0.1 * np.cos(0.6 * t)
    u, place, speed = np.zeros(rows), np.zeros(rows), np.zeros(rows)
    r, v, last = 0.1, 0.0, 0.0
    for k in range(rows):
        place[k], speed[k], u[k] = r, v, last
        last = shake[k] - 0.4 * r - 0.3 * v
        for j in range(50):
            angle = u[k] + (j + 0.5) / 50 * (last - u[k])
            c = 0.1 if t[k] < tilted else -0.3
            rate = 5.0 * np.sin(angle) - 0.3 * v + c
            r, v = r + 0.002 * v + 0.5 * 0.002**2 * rate, v + 0.002 * rate
    return t, u, place, speed


def write_table(path: Path, t, u, y) -> Path:
    rows = [f'{float(a)!r},{float(b)!r},{float(c)!r}' for a, b, c in zip(t, u, y)]
    path.write_text('\n'.join(['t,u,y', *rows]) + '\n')
    return path
