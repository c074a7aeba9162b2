"""Events in a run: none, rest, jumps, and others that the windows do not expect."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from benchmarks.sequence.plants import PLANTS, Change, Parameters, Plant, Run, simulated
from benchmarks.tanks import noise_of
from obs_ros.core.typing import Array

RUN_STREAM = 2  # what a run is drawn from; searches must not draw the same numbers
LAG_NOISE = 0.05
SIZES = ((0.03, 0.1), (0.1, 0.2), (0.2, 0.4))  # classes of jumps, in boxes
ROOM = 0.03  # box that a jump leaves to the bounds
REST_FEED = (10.0, 30.0)  # cm3/s: the levels stay inside the tanks
CALM = 3  # windows of excitation before a rest
OUTLIERS, OUTLIER_SIZE = 0.1, 10.0  # share of samples, and their sd in those of the noise
WRONG = 1.1  # true area over the model's


class Scene(NamedTuple):
    """One run to simulate: `snr` in dB (tanks only), the event, and the number of windows."""

    plant: str
    snr: float
    kind: str
    seed: int
    windows: int  # window lengths of the run


class Drawn(NamedTuple):
    """A run before it is simulated: random generator, times t (K,), inputs u (K, m), p (q,)."""

    plant: Plant
    rng: np.random.Generator
    t: Array
    u: Array
    p: Array
    seed: int

    @property
    def length(self) -> float:
        """Length of a window in s."""
        return self.plant.duration


def run_of(scene: Scene) -> Run:
    """Simulate and measure a scene; the same seed has the same noise at every SNR."""
    plant = PLANTS[scene.plant]
    kinds = list(KINDS)
    rng = np.random.default_rng([scene.seed, RUN_STREAM, kinds.index(scene.kind)])
    t: Array = plant.step * np.arange(0.0, round(scene.windows * plant.duration / plant.step) + 1)
    blocks = int(t[-1] // plant.hold) + 1
    steps = rng.uniform(*plant.feed, (blocks, len(plant.model.inputs)))
    u = np.repeat(steps, round(plant.hold / plant.step), axis=0)[: t.size]
    drawn = Drawn(plant, rng, t, u, rng.uniform(plant.lower, plant.upper), scene.seed)
    sigma = noise_of(scene.snr) if scene.plant == 'tanks' else LAG_NOISE
    return KINDS[scene.kind](drawn, sigma)


def measured(
    drawn: Drawn,
    sigma: float,
    changes: tuple[Change, ...] = (),
    *,
    parameters: Parameters | None = None,
    shape: Array | float = 1.0,
    event: float = np.inf,
    wrong_area: bool = False,
) -> Run:
    """Simulate the run that was drawn; `shape` (K, 1) multiplies the noise."""
    plant, rng = drawn.plant, drawn.rng
    x0 = rng.uniform(*plant.x0, len(plant.model.states))
    truth = Parameters.of(drawn.p, changes) if parameters is None else parameters
    # Wider tanks are the model's with less feed through narrower valves.
    share = 1.0 / WRONG if wrong_area else 1.0
    narrower = Parameters(truth.since, truth.values * share)
    x = simulated(plant.model, drawn.t, drawn.u * share, x0, narrower)
    y = x[:, : len(plant.model.outputs)]  # both plants measure their first states
    y = y + sigma * shape * rng.standard_normal(y.shape)
    return Run(plant, drawn.t, drawn.u, y, x, truth, sigma, changes, event)


def rest(drawn: Drawn, sigma: float, flow: bool = True) -> Run:
    """Hold the inputs after some windows; the tanks' feeds moderate, or none into the first."""
    begin = CALM * drawn.length
    hold(drawn, begin, flow)
    return measured(drawn, sigma, event=begin)


def hold(drawn: Drawn, begin: float, flow: bool = True) -> None:
    """Let the inputs be constant from `begin` (s) on."""
    if drawn.plant is PLANTS['tanks']:
        constant = drawn.rng.uniform(*REST_FEED, 2) * (1.0 if flow else (0.0, 1.0))
    else:
        constant = np.array([0.5])
    drawn.u[drawn.t >= begin] = constant


def jump_and_rest(drawn: Drawn, sigma: float) -> Run:
    """Let p1 jump, later the feeds rest: a story to draw."""
    time = 3.5 * drawn.length
    hold(drawn, 7.0 * drawn.length)
    change = Change(time, 0, -0.25 * float(drawn.p[0]))
    return measured(drawn, sigma, (change,), event=time)


def jump(drawn: Drawn, sigma: float) -> Run:
    """Let one parameter jump; the seed tells the class of its size."""
    size = drawn.rng.uniform(*SIZES[drawn.seed % len(SIZES)])
    time = round(drawn.length * drawn.rng.uniform(3.3, 4.3), 2)
    change = fitting(drawn, time, int(drawn.rng.integers(drawn.p.size)), size)
    return measured(drawn, sigma, (change,), event=time)


def fitting(drawn: Drawn, time: float, place: int, size: float) -> Change:
    """Return a jump by `size` (boxes) that stays in its box; p is drawn anew until there is one."""
    plant, rng = drawn.plant, drawn.rng
    bounds = plant.model.parameters[place]
    width = float(plant.width[place])
    least, most = bounds.lower + ROOM * width, bounds.upper - ROOM * width
    # Half-shut valves hold levels up beyond the box.
    least = max(least, plant.lower[place] - 0.1 * width)
    while True:
        signs = [s for s in (1.0, -1.0) if least < drawn.p[place] + s * size * width < most]
        if signs:
            return Change(time, place, float(rng.choice(signs)) * size * width)
        drawn.p[place] = rng.uniform(plant.lower[place], plant.upper[place])


def ramp(drawn: Drawn, sigma: float, lengths: float) -> Run:
    """Let one parameter go down steadily by a third, over some window lengths."""
    place, begin = int(drawn.rng.integers(drawn.p.size)), 3.5 * drawn.length
    count = round(lengths * drawn.length / drawn.plant.step)
    steps = begin + drawn.plant.step * np.arange(count)
    values = np.tile(drawn.p, (count + 1, 1))
    values[:, place] *= np.linspace(1.0, 2.0 / 3.0, count + 1)
    truth = Parameters(np.array([0.0, *steps]), values)
    return measured(drawn, sigma, parameters=truth, event=begin)


def two_jumps(drawn: Drawn, sigma: float, same: bool) -> Run:
    """Let two parameters jump within a third of a window, or one parameter twice."""
    q, first = drawn.p.size, round(drawn.length * drawn.rng.uniform(3.3, 4.3), 2)
    j = int(drawn.rng.integers(q))
    k = j if same else (j + 1) % q
    second = round(first + drawn.length / 3.0, 2)
    one = Change(first, j, -0.3 * float(drawn.p[j]))
    two = Change(second, k, (0.2 if same else -0.3) * float(drawn.p[k]))
    return measured(drawn, sigma, (one, two), event=first)


def noisier(drawn: Drawn, sigma: float) -> Run:
    """Let the noise treble half way."""
    begin = float(drawn.t[drawn.t.size // 2])
    shape = np.where(drawn.t >= begin, 3.0, 1.0)[:, None]
    return measured(drawn, sigma, shape=shape, event=begin)


def outliers(drawn: Drawn, sigma: float) -> Run:
    """Let some samples be far noisier than the others, all the time."""
    far = drawn.rng.random((drawn.t.size, len(drawn.plant.model.outputs))) < OUTLIERS
    return measured(drawn, sigma, shape=np.where(far, OUTLIER_SIZE, 1.0), event=0.0)


def wrong_pipes(drawn: Drawn, sigma: float) -> Run:
    """Let the valves be wider than the model says: their openings are found too large."""
    truth = Parameters.of(drawn.p / WRONG)
    return replace(measured(drawn, sigma, event=0.0), parameters=truth)


KINDS: Mapping[str, Callable[[Drawn, float], Run]] = {
    'clean': measured,
    'rest': rest,
    'rest, Q1 = 0': lambda drawn, sigma: rest(drawn, sigma, flow=False),
    'jump': jump,
    'ramp over 3 windows': lambda drawn, sigma: ramp(drawn, sigma, 3.0),
    'ramp over 10 windows': lambda drawn, sigma: ramp(drawn, sigma, 10.0),
    'two jumps, two parameters': lambda drawn, sigma: two_jumps(drawn, sigma, same=False),
    'two jumps, one parameter': lambda drawn, sigma: two_jumps(drawn, sigma, same=True),
    'noise x 3 from half way': noisier,
    '10 % outliers': outliers,
    'wrong pipe area': wrong_pipes,
    'wrong tank area': lambda drawn, sigma: measured(drawn, sigma, event=0.0, wrong_area=True),
    'jump and rest': jump_and_rest,
}
