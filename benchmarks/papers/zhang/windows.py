"""Sliding windows on the heat exchanger: flows, faults of its valves, and words of advice.

Samples at 20 Hz of the plant with the stems' inertia, windows of 4 s on the model without it.
"""

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from benchmarks.papers.seeds import few, seeds_of
from benchmarks.papers.zhang.plants import steady
from benchmarks.play import played, samples_of
from benchmarks.report import rms
from benchmarks.runner import monte_carlo
from obs_ros import Estimate
from obs_ros.core.typing import Array, BoolArray
from obs_ros.models import heat_exchanger as plant
from obs_ros.observers.sliding_window import SlidingWindowObserver
from plant_sim.scenario import Scenario
from plant_sim.scenarios import load_scenario
from plant_sim.scenarios.heat_exchanger import AT_REST, NOMINAL, PRESSURES
from plant_sim.signals import Schedule, Signal, constant
from plant_sim.simulation import Instant

PERIOD = 0.05  # s, of samples
DURATION = 4.0  # s, of windows
EVERY = 0.5  # s, from window to window
BEGIN, END = 70.0, 180.0  # s, of case 2
FAULTS = (80.0, 150.0)  # s, of case 2: first Fu's valve, then Fp's
SETTLING = 4.0  # s after a fault that do not count as plateau
DEADLINE = 2.0  # s after a fault by which its valve must be known
VALVES = ({'dP1', 'k1'}, {'dP2', 'k2'})  # utility, process
SIZES = {'dP1': -2.0e5, 'k1': 1000.0, 'dP2': -2.0e4, 'k2': 1000.0}  # Pa, N/m
STATES = ('Tp', 'Tu', 'X1', 'X2')
STEADY = (*steady(NOMINAL), *AT_REST)
NOISES = {'0.1 K, correlated over 0.1 s': (0.1, 0.1), '0.1 K, white': (0.1, 0.0)}
ALL = ('dP1', 'dP2', 'k1', 'k2')
WATCHES = {
    'pressures move, all four unknown': (True, ALL),
    'constant pressures, dP1 and k1 unknown': (False, ('dP1', 'k1')),
    'constant pressures, all four unknown': (False, ALL),
}
WATCHED = (8.0, 20.0)  # s, of clean windows
PLACES = {v.name: i for i, v in enumerate(plant.HEAT_EXCHANGER.parameters)}
BOXES = {
    v.name: v.upper - v.lower
    for v in (*plant.HEAT_EXCHANGER_REDUCED.states, *plant.HEAT_EXCHANGER_REDUCED.parameters)
}


def sampled(
    scenario: Scenario,
    seed: int,
    sigma: float,
    correlation: float,
    end: float,
    play: float = PERIOD,
) -> list[Instant]:
    """Play a scenario to `end` (s); noise of `sigma` K, correlated over as many s.

    It is sampled every `play` s, between which the plant holds its inputs; of these samples one in
    PERIOD is returned.
    """
    noisy = replace(scenario, noise_correlation=correlation)
    snr = -20.0 * math.log10(sigma) if sigma else math.inf
    instants = played(noisy, round(end / play) + 1, period=play, seed=seed, snr_db=snr)
    return instants[:: round(PERIOD / play)]


def estimates(
    instants: Sequence[Instant], sigma: float, seed: int, **settings: Any
) -> list[Estimate]:
    """Solve the windows of a run, told the noise's sigma (K; 0 = not told) and not its colour."""
    observer = SlidingWindowObserver(
        'heat_exchanger_reduced',
        duration=DURATION,
        period=EVERY,
        noise={'Tp': sigma, 'Tu': sigma} if sigma else None,
        seed=seed,
        **settings,
    )
    found = []
    for sample in samples_of(instants):
        if observer.absorb(sample) and (one := observer.estimate()):
            found.append(one)
    return found


class Followed(NamedTuple):
    """Case 2: times (W,) of estimates, relative errors of Fp and Fu (W, 2), sd of dP1 and k2."""

    t: Array
    error: Array
    sd: Array

    @property
    def plateau(self) -> BoolArray:
        """Where (W,) flows have long been constant."""
        fresh = [(self.t >= fault) & (self.t < fault + SETTLING) for fault in (BEGIN, *FAULTS)]
        return np.asarray(~np.any(fresh, axis=0))

    @property
    def rms(self) -> Array:
        """RMS (%) of Fp and Fu on the plateaus."""
        return 100.0 * np.asarray(rms(self.error[self.plateau], 0))


def followed(seed: int | None) -> Followed:
    """Follow the flows of case 2 by dP1 and k2; without noise if there is no seed."""
    sigma = 0.0 if seed is None else 0.05
    instants = sampled(load_scenario('heat_exchanger_case2'), seed or 0, sigma, 0.1, END)
    instants = instants[round(BEGIN / PERIOD) :]
    found = estimates(instants, sigma, seed or 0, parameters=('dP1', 'k2'))
    truth = {round(i.t, 6): np.array(flows(i.p, i.x[2], i.x[4])) for i in instants}
    t = np.array([one.t1 for one in found])
    error = [
        np.array(flows(list(one.parameters.values()), one.state['X1'], one.state['X2']))
        / truth[round(one.t1, 6)] - 1.0
        for one in found
    ]  # fmt: skip
    sd = [[one.stddev['dP1'], one.stddev['k2']] for one in found]
    return Followed(t, np.array(error), np.array(sd))


def flows(p: Sequence[float], x1: float, x2: float) -> tuple[float, float]:
    """Return Fp and Fu (m3/s) from dP1, dP2, k1, k2 and the openings."""
    return plant.flow2(p[1], x2), plant.flow1(p[0], x1)


class Isolated(NamedTuple):
    """The newest window DEADLINE after a fault, and when the valve was first named.

    `named` tells whether the set that wins the jump search has parameters of the right valve only,
    `partner` whether the equivalent parameter of that valve is named as well, as the one or among
    the alternatives; `clear` whether all alternatives are of that valve. `error` is that of the
    moment found (s).
    `first` (s) is after how long a window first named the valve, `false` the alarms before.
    """

    named: bool
    partner: bool
    clear: bool
    error: float
    first: float
    false: int


def isolated(parameter: str, sigma: float, correlation: float, seed: int) -> Isolated:
    """Let one parameter jump, all four unknown, and ask which valve is faulty.

    The seed is that of the noise (K, correlated over s) and of the moment.
    """
    moment = 16.0 + PERIOD * int(np.random.default_rng([seed, 7]).integers(EVERY / PERIOD))
    after = list(NOMINAL)
    after[PLACES[parameter]] += SIZES[parameter]
    scenario = replace(
        load_scenario('heat_exchanger_case1'),
        initial_state=STEADY,
        parameters=Schedule((0.0, moment), (NOMINAL, tuple(after))),
    )
    instants = sampled(scenario, seed, sigma, correlation, moment + DEADLINE)
    # So begun that a window ends DEADLINE after the fault, and not somewhat before.
    instants = instants[round(math.fmod(moment, EVERY) / PERIOD) :]
    found = estimates(instants, sigma, seed)
    (valve,) = (each for each in VALVES if parameter in each)
    false = sum(any(jump.new for jump in one.jumps) for one in found if one.t1 <= moment)
    first = math.inf
    last: tuple[bool, bool, bool, float] = (False, False, False, math.nan)
    for one in found:
        jumps = [jump for jump in one.jumps if jump.time > moment - 1.0]
        if one.t1 <= moment or not jumps:
            continue
        jump = min(jumps, key=lambda each: abs(each.time - moment))
        sets = [set(jump.sizes)]
        others = [set(words.split(' and ')) for words in jump.alternatives]
        named = sets[0] <= valve
        if named and math.isinf(first):
            first = one.t1 - moment
        singles = [each for each in (*sets, *others) if each <= valve]
        partner = set().union(*singles) == valve
        clear = named and all(each <= valve for each in others)
        last = (named, partner, clear, jump.time - moment)
    return Isolated(*last, first, false)


class Watched(NamedTuple):
    """Errors and standard deviations (W, q) and (W, n) in boxes, words and new jumps."""

    p_error: Array
    p_sd: Array
    x_error: Array
    x_sd: Array
    weak: tuple[tuple[str, ...], ...]
    alarms: int


def watched(moving: bool, seed: int, parameters: tuple[str, ...]) -> Watched:
    """Watch a plant whose parameters stay where they are, with white noise of 0.05 K.

    The pressures are `moving` or constant.
    """
    rng = np.random.default_rng([seed, 8])
    p = list(NOMINAL)
    for name in parameters:
        p[PLACES[name]] *= rng.uniform(0.8, 1.2)
    scenario = replace(
        load_scenario('heat_exchanger_case1'),
        initial_state=STEADY,
        inputs=ramps(rng) if moving else constant(*PRESSURES),
        parameters=constant(*p),
    )
    play = 1e-3 if moving else PERIOD  # fine where held pressures would differ from ramps
    instants = sampled(scenario, seed, 0.05, 0.0, WATCHED[1], play)
    instants = instants[round(WATCHED[0] / PERIOD) :]
    found = estimates(instants, 0.05, seed, parameters=parameters)
    truth = {round(i.t, 6): i.x for i in instants}
    x = np.array([truth[round(one.t1, 6)] for one in found])[:, (0, 1, 2, 4)]
    p_box, x_box = (np.array([BOXES[name] for name in names]) for names in (parameters, STATES))

    def told(kind: str, names: Sequence[str]) -> Array:
        return np.array([[getattr(one, kind)[name] for name in names] for one in found])

    return Watched(
        (told('parameters', parameters) - [p[PLACES[name]] for name in parameters]) / p_box,
        told('stddev', parameters) / p_box,
        (told('state', STATES) - x) / x_box,
        told('stddev', STATES) / x_box,
        tuple(one.weak for one in found),
        sum(any(jump.new for jump in one.jumps) for one in found),
    )


def ramps(rng: np.random.Generator) -> Signal:
    """Return pressures that move to other levels, within 20 %, every 2 s and in half a second."""
    levels = np.array(PRESSURES) * rng.uniform(0.8, 1.2, (40, 2))

    @functools.cache
    def pressures(t: float) -> tuple[float, ...]:
        step, rest = divmod(t, 2.0)
        share = min(1.0, rest / 0.5)
        old, new = levels[int(step)], levels[int(step) + 1]
        return tuple(float(v) for v in old + share * (new - old))

    return pressures


class Windows(NamedTuple):
    """All runs of windows: case 2 without noise and with, by noise and fault, by kind of watch."""

    quiet: Followed
    noisy: Sequence[Followed]
    faults: Mapping[str, Mapping[str, Sequence[Isolated]]]
    watches: Mapping[str, Sequence[Watched]]


def windows_of(seeds: int) -> Windows:
    """Return all runs: of so many seeds for each rate, those of faults by noise in equal parts."""
    noises = seeds_of('zhang', 'case 2 in windows', few(seeds))
    cases = monte_carlo(
        followed, {'quiet': [(None,)], 'noisy': [(seed,) for seed in noises]}, 'case 2 in windows'
    )
    kinds = {
        (label, name): [
            (name, *noise, seed)
            for seed in seeds_of('zhang', f'fault of {name}, {label}', -(-seeds // len(SIZES)))
        ]
        for label, noise in NOISES.items()
        for name in SIZES
    }
    found = monte_carlo(isolated, kinds, 'faults')
    faults = {label: {name: found[label, name] for name in SIZES} for label in NOISES}
    watches = {
        label: [(moving, seed, parameters) for seed in seeds_of('zhang', label, seeds)]
        for label, (moving, parameters) in WATCHES.items()
    }
    seen = monte_carlo(watched, watches, 'clean windows')
    return Windows(cases['quiet'][0], cases['noisy'], faults, seen)
