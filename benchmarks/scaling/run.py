"""Solves of ever more samples, unknowns, lanes, output rate, and plants in one process."""

import time
from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.metered import Spent, spent
from benchmarks.report import quantiles
from benchmarks.runner import cpu_seconds, progress, repeats_for
from benchmarks.scaling.curve import CAUSES, Curve
from benchmarks.tanks import random_window
from benchmarks.zoo import CASES, draw
from benchmarks.zoo.cases import chain
from obs_ros import Record, Sample
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.models.three_tank import THREE_TANK
from obs_ros.observers.sliding_window import SlidingWindowObserver

SNR = 20.0  # dB
SAMPLES = (50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000)
TANKS = (2, 4, 6, 8, 10)
FREE = (4, 6, 8, 10, 12, 14, 16)  # of the 16 unknowns of a chain of 8
LANES = (16, 32, 64, 128, 256, 512)
PERIODS = (10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1)  # s, over DURATION
DURATION = 1000.0  # s
PLANTS = (1, 2, 4, 8, 16)
PLANT_SAMPLES, PLANT_WINDOWS = 200, 4
MEASUREMENT = 0.05  # s of process time
LANE_SAMPLES = 1000
KERNELS = ('squares', 'grams', 'trajectories')
PLANT_ROUNDS = 5


def solved_curve(
    title: str,
    x_name: str,
    x: Sequence[float],
    solves: Callable[[int, int], Spent],
    seeds: Sequence[int],
    remark: str,
) -> Curve:
    """Solve windows at every size: `solves(i, seed)` does one of size x[i]."""
    rows, seconds = [], []
    causes: dict[str, list[float]] = {name: [] for name in CAUSES}
    for i, size in progress(enumerate(x), title, len(x)):
        solves(i, seeds[0])  # compiles, warms
        runs = [solves(i, seed) for seed in seeds]
        median, high = quantiles(run.seconds for run in runs)
        for name, cause in CAUSES.items():
            causes[name].append(float(np.median([cause(run) for run in runs])))
        steps, calls, per_step, _ = (values[-1] for values in causes.values())
        candidates = np.median([run.estimate.evaluations for run in runs])
        rows.append({
            x_name: f'{size:g}',
            'median (ms)': f'{1e3 * median:.2f}',
            'p95 (ms)': f'{1e3 * high:.1f}',
            'candidate-steps (10^6)': f'{1e-6 * steps:.2f}',
            'kernel calls': f'{calls:.0f}',
            'candidates': f'{candidates:.0f}',
            'ns / candidate-step': f'{1e9 * per_step:.1f}',
            'outside kernels (%)': f'{100.0 * np.median([run.rest for run in runs]):.0f}',
            f'converged of {len(seeds)}': sum(r.estimate.outcome == 'converged' for r in runs),
        })  # fmt: skip
        seconds.append(median)
    return Curve(title, x_name, x, seconds, rows, remark, causes)


def by_samples(samples: Sequence[int], seeds: Sequence[int]) -> Curve:
    """Three tanks, one sample a second, ever longer."""
    return solved_curve(
        'samples per window',
        'samples',
        samples,
        lambda i, seed: spent(THREE_TANK, random_window(seed, samples[i], SNR).record, seed),
        seeds,
        'Three tanks, 6 unknowns, a sample every second: the window gets longer, too.',
    )


def by_rate(periods: Sequence[float], seeds: Sequence[int]) -> Curve:
    """Three tanks, the same time, ever more samples."""
    samples = [round(DURATION / period) for period in periods]
    return solved_curve(
        'output rate',
        'samples per s',
        [1.0 / period for period in periods],
        lambda i, seed: spent(
            THREE_TANK, random_window(seed, samples[i], SNR, periods[i]).record, seed
        ),
        seeds,
        f'Three tanks, 6 unknowns, {DURATION:g} s: the window stays as long. A step of integration '
        'lasts 1 s at the most, so that below one sample per s the steps stay as many.',
    )


def by_tanks(tanks: Sequence[int], seeds: Sequence[int]) -> Curve:
    """Ever longer rows of tanks."""
    cases = [chain(count) for count in tanks]
    return solved_curve(
        'unknowns, with the plant',
        'unknowns',
        [2 * count for count in tanks],
        lambda i, seed: spent(cases[i].model, draw(cases[i], seed).record, seed),
        seeds,
        f'Rows of {tanks[0]} to {tanks[-1]} tanks, 1000 samples, half of the levels measured, all '
        'levels and valves unknown. With them grow the candidates of a Jacobian, the states '
        'and outputs of a candidate-step, and the iterations along an ever longer flat valley, so '
        'that a power of 2 and more is the end of it; the share outside the kernels hides it here.',
    )


def by_free(free: Sequence[int], seeds: Sequence[int]) -> Curve:
    """Return the curve of a chain of 8 of which ever more is unknown."""
    case = CASES['chain of 8']
    # Valves and levels in turn, from the feed on: each new one is next to those before.
    order = [f'{kind}{i}' for i in range(8) for kind in 'ph']

    def solve(i: int, seed: int) -> Spent:
        window = draw(case, seed)
        fixed = {name: window.truth[name] for name in order[free[i] :]}
        return spent(case.model, window.record, seed, fixed=fixed)

    return solved_curve(
        'unknowns of one plant',
        'unknowns',
        free,
        solve,
        seeds,
        'A chain of 8 tanks, 1000 samples; what is not unknown is given its true value. A Jacobian '
        'takes a candidate for every unknown, a Gram matrix their square; the last tank, farthest '
        'from the feed, is hard to tell and costs more iterations (kernel calls).',
    )


def by_lanes(lanes: Sequence[int]) -> Curve:
    """Return the curve of single kernel calls with ever more candidates."""
    record = random_window(1, LANE_SAMPLES, SNR).record
    grid = Grid.of(THREE_TANK, record, np.ones(2))
    kernels, prefixes, width = kernels_for(THREE_TANK), np.array([LANE_SAMPLES]), 7
    rows, seconds = [], []
    for count in lanes:
        rng = np.random.default_rng(count)
        x0, p = rng.uniform(5.0, 95.0, (3, count)), rng.uniform(0.2, 1.0, (3, count))
        calls = (
            lambda x0=x0, p=p: kernels.squares(grid, prefixes, x0, p),
            lambda x0=x0, p=p: kernels.grams(grid, LANE_SAMPLES, x0, p, width),
            lambda x0=x0, p=p: kernels.trajectories(grid, x0, p),
        )
        pairs = [(call, repeats_for(call, MEASUREMENT)) for call in calls]
        times = [float(np.median([cpu_seconds(*pair) for _ in range(7)])) for pair in pairs]
        unit = 1e9 / (count * (LANE_SAMPLES - 1))
        row = {f'{name} (ns)': f'{unit * s:.1f}' for name, s in zip(KERNELS, times, strict=True)}
        rows.append({'lanes': count, **row, 'squares, a call (ms)': f'{1e3 * times[0]:.2f}'})
        seconds.append(times[0])
    return Curve(
        'lanes of the kernel',
        'lanes',
        lanes,
        seconds,
        rows,
        f'Three tanks, {LANE_SAMPLES} samples: ns per candidate-step of the three kernels; `grams` '
        'with 6 unknowns, its products included. The exponent is that of `squares`.',
    )


def by_plants(plants: Sequence[int], seed: int) -> Curve:
    """Return the curve of ever more observers in one process, fed in turn, sample by sample."""
    record = random_window(seed, PLANT_SAMPLES * PLANT_WINDOWS, SNR).record
    fed(record, 1)  # warm
    rows, seconds = [], []
    # Interleaved: what else the machine does must not look like growth.
    runs = [[fed(record, count) for count in plants] for _ in range(PLANT_ROUNDS)]
    for count, (storing, solving, estimates) in zip(plants, np.median(runs, axis=0), strict=True):
        rows.append({
            'plants': count,
            'estimates': f'{estimates:.0f}',
            'process time (ms)': f'{1e3 * (storing + solving):.1f}',
            'an estimate (ms)': f'{1e3 * solving / estimates:.2f}',
            'storing a sample (us)': f'{1e6 * storing / (count * record.t.size):.1f}',
        })  # fmt: skip
        seconds.append(storing + solving)
    return Curve(
        'plants in one process',
        'plants',
        plants,
        seconds,
        rows,
        f'Observers of three tanks with windows of {PLANT_SAMPLES} samples, {PLANT_WINDOWS} one '
        'after the other, fed in turn; all get the same samples, so that each has the same work.',
    )


def fed(record: Record, count: int) -> tuple[float, float, int]:
    """Feed observers in turn: process time in s of storing and of solving, and the estimates."""
    observers = [
        SlidingWindowObserver('three_tank', duration=float(PLANT_SAMPLES - 1)) for _ in range(count)
    ]
    storing, solving, estimates = 0.0, 0.0, 0
    for t, u, y in zip(record.t, record.u, record.y, strict=True):
        sample = Sample(round(1e9 * t), y, u)
        due: list[SlidingWindowObserver] = []
        for observer in observers:
            begin = time.process_time()
            if observer.absorb(sample):
                due.append(observer)
            storing += time.process_time() - begin
        for observer in due:
            solving += cpu_seconds(observer.estimate)
        estimates += len(due)
    return storing, solving, estimates
