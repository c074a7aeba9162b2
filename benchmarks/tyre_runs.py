"""Runs of observers of the suspension's tyre stiffness, and what is measured in them."""

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from obs_ros import Sample, load_observer
from obs_ros.models.suspension import KT
from obs_ros.typing import Array
from plant_sim.scenarios import load_scenario
from plant_sim.scenarios.suspension import BUMPS
from plant_sim.simulation import Simulation

FIRST = 24.0  # s, when both bumps are passed: what counts
NEAR = 0.1  # of kt
BEGIN, END = 7.0, 28.0  # s; before and after that the road is straight: nothing is learnt there


class Contestant(NamedTuple):
    """An observer by name, with its settings."""

    label: str
    observer: str
    settings: dict[str, Any]


# Whoever estimates kt of this plant can be added here.
CONTESTANTS = (
    Contestant('filtered regressor, designed gains', 'h_infinity', {}),
    Contestant(
        "the paper's: gradient, printed gains", 'h_infinity',
        {'adaptation': 'gradient', 'gains': 'printed'},
    ),
    Contestant('gradient, designed gains', 'h_infinity', {'adaptation': 'gradient'}),
    Contestant('EKF on (x, kt)', 'ekf', {'parameters': ('kt',)}),
    Contestant('EKF on (x, kt, eta)', 'ekf', {}),
)  # fmt: skip


class Case(NamedTuple):
    """A road, the force on the damper (N) that is reached at 12 s, and noise (m)."""

    scenario: str
    force: float
    noise: float

    @property
    def label(self) -> str:
        """Return the case in words."""
        road = self.scenario.removeprefix('suspension_')
        return f'{road}, eta {self.force:g} N, {1e3 * self.noise:g} mm'


CASES = (
    Case('suspension_trap', 0.0, 1e-4),
    Case('suspension_trap', 300.0, 1e-4),
    Case('suspension_trap', 300.0, 1e-3),
    Case('suspension_cos', 0.0, 1e-3),
    Case('suspension_kt_step', 300.0, 1e-4),
)


class Task(NamedTuple):
    """One run; the seed is that of the noise."""

    contestant: Contestant
    case: Case
    seed: int


class Measured(NamedTuple):
    """RMS (%) of kt from FIRST on, s from the first bump until within NEAR, and finiteness."""

    rms: float
    near: float
    finite: bool


@functools.cache
def played(scenario: str, disturbed: bool) -> tuple[Array, Array, Array, Array]:
    """Times (K,), inputs (K, 2), positions without noise (K, 3) and true kt (K,)."""
    simulation = Simulation(load_scenario(scenario), snr_db=math.inf)
    simulation.faults = {} if disturbed else {'eta': 0.0}
    rows = [simulation.sample() for _ in range(round(END / simulation.period) + 1)]
    rows = rows[round(BEGIN / simulation.period) :]
    t, u, y, p = (np.array([getattr(i, name) for i in rows]) for name in ('t', 'u', 'y', 'p'))
    return t, u, y, p[:, 0]


def observed(task: Task) -> tuple[Array, Array, Array]:
    """Return times, estimates and truth of kt; the estimate starts from half of it."""
    t, u, y, kt = played(task.case.scenario, task.case.force > 0.0)
    y = y + task.case.noise * np.random.default_rng(task.seed).standard_normal(y.shape)
    observer: Any = load_observer(task.contestant.observer)(
        'suspension',
        initial={'kt': 0.5 * KT},
        noise=dict.fromkeys(('zs', 'zus', 'zd'), task.case.noise),
        **task.contestant.settings,
    )
    found = np.empty_like(t)
    for k, stamp in enumerate(np.round(t * 1e9).astype(np.int64).tolist()):
        observer.absorb(Sample(stamp, y=y[k], u=u[k]))
        found[k] = observer.p[0]
    return t, found, kt


def measured(task: Task) -> Measured:
    """Let an observer drive over the road, and measure."""
    t, found, kt = observed(task)
    error = found / kt - 1.0
    near = (t >= BUMPS[0]) & (np.abs(error) <= NEAR)
    return Measured(
        float(100.0 * np.sqrt(np.mean(error[t > FIRST] ** 2))),
        float(t[near.argmax()] - BUMPS[0]) if near.any() else math.inf,
        bool(np.isfinite(found).all()),
    )
