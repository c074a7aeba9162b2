"""States of the valves, X and V, by the paper's observer without noise."""

import math
from typing import NamedTuple

import numpy as np

from benchmarks.papers.zhang.plants import (
    COLD,
    MOVING,
    PROCESS,
    UTILITY,
    Case,
    scenario_of,
    truth_of,
)
from benchmarks.play import Contestant, columns, played
from benchmarks.report import rms
from obs_ros import Sample, load_observer
from obs_ros.core.model import names
from obs_ros.core.typing import Array
from obs_ros.models.heat_exchanger import HEAT_EXCHANGER

STATES = names(HEAT_EXCHANGER.states)
OPENINGS, RATES = ([STATES.index(f'{kind}{i}') for i in (1, 2)] for kind in 'XV')
SHUT = {'X1': 0.0, 'X2': 0.0}  # no flow at the start, as section 4.3.1 has it


class Valves(NamedTuple):
    """Errors of X1 and X2, V1 and V2.

    `opened` are relative errors (K, 2) of X from shut valves on, at times `t` (K,); `moving` the
    RMS errors (2,) of V in motion by the RMS of V; `faulty` the relative errors (2,) of X1 after
    the fault of its valve, and of X2 after that of its own.
    """

    t: Array
    opened: Array
    moving: Array
    faulty: Array


def valves(paper: Contestant) -> Valves:
    """Watch the valves open in case 1, move in case 3, and fail in case 2."""
    t, error, truth = watched(paper, COLD, {'initial': SHUT})
    opened = error[:, OPENINGS] / truth[:, OPENINGS]
    _, error, truth = watched(paper, MOVING)
    moving = rms(error[:, RATES], 0) / rms(truth[:, RATES], 0)
    ends = []
    for i, case in zip(OPENINGS, (UTILITY, PROCESS), strict=True):
        _, error, truth = watched(paper, case)
        ends.append(error[-1, i] / truth[-1, i])
    return Valves(t, opened, moving, np.array(ends))


def watched(
    one: Contestant, case: Case, more: dict[str, object] | None = None
) -> tuple[Array, Array, Array]:
    """Return times (K,), errors and true values (K, 6) of all states."""
    t, u, y, _ = truth_of(case)
    (truth,) = columns(played(scenario_of(case), len(t), snr_db=math.inf), 'x')
    observer = load_observer(one.observer)('heat_exchanger', **one.settings, **(more or {}))
    x = np.empty_like(truth)
    for k, stamp in enumerate(np.round(t * 1e9).astype(np.int64).tolist()):
        observer.absorb(Sample(stamp, y=y[k], u=u[k]))
        x[k] = observer.x
    return t, x - truth, truth
