"""The extended Kalman filter of Gremling & Passino 2000, section 6.3: parameters known.

Textbook equations on the forward Euler model (eq. 22), with diagonal covariances as the paper tries
them. It leaves the initial covariance open, and whether R is kept at 0 or above; both are varied.
"""

import itertools
from typing import NamedTuple

import numpy as np

from benchmarks.papers.gremling.plan import JET_START
from benchmarks.papers.truth import PERIOD, truth_of
from obs_ros import load_model
from obs_ros.core.typing import Array
from obs_ros.observers.papers.euler import euler_step

FAR = 10.0  # an error beyond which a filter counts as unstable: states are of size 1
PROCESS = (0.0, 1e-9, 1e-7, 1e-5)  # variance of each state's noise, a sample
OUTPUT = (1e-9, 1e-7, 1e-5)  # variance of the output's
START = (1e-7, 1e-3, 1e-1, 1.0)  # variance of each state at first
STEP = 1e-6  # of central differences


class Configuration(NamedTuple):
    """A filter on a scenario: variances of process, output and start; whether R >= 0 is kept."""

    scenario: str
    process: float
    output: float
    start: float
    kept: bool


def configurations(scenario: str) -> list[Configuration]:
    """Return the filters that are tried on a scenario."""
    varied = itertools.product(PROCESS, OUTPUT, START, (False, True))
    return [Configuration(scenario, *each) for each in varied]


def unstable(configuration: Configuration) -> bool:
    """Run a filter; tell whether an estimate leaves its true state, or is no number."""
    truth = truth_of(configuration.scenario, 0)
    with np.errstate(all='ignore'):
        error = np.abs(filtered(configuration, truth.u, truth.y) - truth.x)
    return not bool((error <= FAR).all())


def filtered(configuration: Configuration, u: Array, y: Array) -> Array:
    """Return the estimated states (K, 3) of Psi, R and Phi, from u and y (K, 1)."""
    model = load_model('jet_engine')
    p = np.array([variable.nominal for variable in model.parameters])
    x = np.array([y[0, 0], JET_START['R'], JET_START['Phi']])
    covariance = configuration.start * np.eye(3)
    found = [x]
    for k in range(1, len(y)):
        around = x[:, None] + STEP * np.hstack([np.zeros((3, 1)), np.eye(3), -np.eye(3)])
        ends = euler_step(model, 0.0, PERIOD, around, u[k - 1], p)
        slope = (ends[:, 1:4] - ends[:, 4:]) / (2.0 * STEP)
        covariance = slope @ covariance @ slope.T + configuration.process * np.eye(3)
        gain = covariance[:, 0] / (covariance[0, 0] + configuration.output)
        x = ends[:, 0] + gain * (y[k, 0] - ends[0, 0])
        covariance = covariance - np.outer(gain, covariance[0])
        if configuration.kept:
            x[1] = max(x[1], 0.0)
        found.append(x)
    return np.array(found)
