"""Every observer on the scenario that it is for, and some on three tanks with free valves."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from benchmarks.play import columns, followed, played, samples_of
from obs_ros import load_observer
from obs_ros.core.typing import Array
from plant_sim.scenarios import load_scenario

TANKS = 'three_tank'
SCENARIOS = {
    'sliding_window': TANKS,
    'gao': 'glycolytic_oscillator',
    'ekf': TANKS,
    'ukf': TANKS,
    'h_infinity': 'suspension_trap',
    'high_gain': 'heat_exchanger_case2',
    'interconnected': 'heat_exchanger_case2',
    'unknown_input': 'heat_exchanger_case2',
}
FORM = 'observer_form_third_order'  # of all others
WINDOW: dict[str, Any] = {'duration': 300.0, 'period': 50.0}  # s, as in the demo
FILTERS: Mapping[str, dict[str, Any]] = {
    'sliding_window': WINDOW,
    'ekf': {},
    'ukf': {},
    'gase': {'mode': 'window_end'},
}
NOISE = 0.01  # cm, sd of the tanks' levels at 40 dB
ENDS = (1999, 2999)  # s


class Cost(NamedTuple):
    """Median process times in us: to absorb a sample, and so with the estimate where one is due.

    `due` is the share of samples at which one is.
    """

    observer: str
    scenario: str
    absorb: float
    estimate: float
    due: float


class Valves(NamedTuple):
    """Absolute errors of the openings (N, 3) at ENDS of all seeds, and their deviations."""

    observer: str
    errors: Array
    sd: Array


def cost(name: str, count: int) -> Cost:
    """Time an observer; the sliding window's estimate is one solve."""
    scenario = SCENARIOS.get(name, FORM)
    settings = WINDOW if name == 'sliding_window' else {}
    observer = load_observer(name)(load_scenario(scenario).model, **settings)
    estimates, times = followed(observer, samples_of(played(scenario, count, seed=0)))
    due = np.array([estimate is not None for estimate in estimates])
    absorb, fetch = 1e6 * np.median(times[:, 0]), 1e6 * np.median(times[due, 1])
    return Cost(name, scenario, float(absorb), float(fetch), float(due.mean()))


def valves(name: str, seeds: int) -> Valves:
    """Let an observer find the valves; all but the sliding window are told the noise."""
    off, sd = [], []
    for seed in range(seeds):
        instants = played(TANKS, ENDS[-1] + 1, seed=seed)
        (truth,) = columns(instants, 'p')
        known = {} if name == 'sliding_window' else {'noise': {'h1': NOISE, 'h2': NOISE}}
        observer = load_observer(name)(TANKS, **known, **FILTERS[name])
        estimates, _ = followed(observer, samples_of(instants))
        usable = [one for one in estimates if one is not None and one.usable]
        for end in ENDS:
            last = [one for one in usable if one.t1 <= end][-1]
            off.append(np.abs(np.array(list(last.parameters.values())) - truth[end]))
            sd.append([last.stddev[valve] for valve in last.parameters])
    return Valves(name, np.array(off), np.array(sd))
