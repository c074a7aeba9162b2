"""Runs of plants that nobody has tuned to: what happens in them, and what they measure."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.sequence.jumps_elsewhere.truth import Course, trajectory
from benchmarks.sequence.jumps_elsewhere.unmodelled import UNMODELLED
from benchmarks.sequence.plants import Change, Parameters
from benchmarks.zoo.experiments import EXPERIMENTS, Experiment
from obs_ros import Record
from obs_ros.core.typing import Array, BoolArray, IntArray

STREAM = 3  # what a run is drawn from; searches must not draw the same numbers
SIZES = (0.15, 0.40)  # of a parameter, that it jumps by
ROOM = 0.005  # of the box, that a jump leaves to the bounds
QUIET = 3.0  # window lengths before the first jump, at least
APART = 4.0  # window lengths between two jumps, at least
TWICE = 3  # every so manieth run has two jumps
CORRELATION = 0.5  # of neighbouring samples of coloured noise
OUTLIER = 10.0  # standard deviations of the noise
SPOILED = 0.5  # share of the windows with an outlier
AMPLITUDE, OSCILLATIONS = 0.15, 2.5  # of a parameter that oscillates, and in a window
SLOPE = 0.3  # share by which a parameter rises or falls that does so steadily


class Kind(NamedTuple):
    """What happens in a run, and what its noise is.

    `missing` is the share of the term that the model leaves out; `ramp` the window lengths over
    which a parameter changes steadily, 0 for none.
    """

    noise: str = 'white'
    jumps: bool = False
    missing: float = 0.0
    oscillates: bool = False
    outliers: bool = False
    ramp: float = 0.0


CLEAN, JUMP, BESIDE = 'clean', 'jump', 'outliers and a jump'
KINDS: Mapping[str, Kind] = {
    CLEAN: Kind(),
    JUMP: Kind(jumps=True),
    'coloured noise': Kind(noise='coloured'),
    't3 noise': Kind(noise='t3'),
    'outliers': Kind(outliers=True),
    BESIDE: Kind(outliers=True, jumps=True),
    'unmodelled 5 %': Kind(missing=0.05),
    'unmodelled 10 %': Kind(missing=0.10),
    'oscillating': Kind(oscillates=True),
    'ramp over 5 windows': Kind(ramp=5.0),
    'ramp over 16 windows': Kind(ramp=16.0),
}
PLANTS = ('cells', 'Monod', 'compartments', 'motor', 'van der Pol')


class Scene(NamedTuple):
    """One run to simulate: plant, kind, rich or poor excitation, and the number of windows."""

    plant: str
    kind: str
    rich: bool
    seed: int
    windows: int

    @property
    def experiment(self) -> Experiment:
        """The plant, with the windows that it is watched through."""
        return EXPERIMENTS[self.plant]

    @property
    def length(self) -> float:
        """Length of a window in s."""
        return self.experiment.samples * self.experiment.interval


class Run(NamedTuple):
    """A run with its truth: t (K,), u (K, m), y (K, r), states x (K, n), parameters p (K, q).

    `spoiled` (K,) tells the samples with an outlier.
    """

    scene: Scene
    t: Array
    u: Array
    y: Array
    x: Array
    p: Array
    changes: tuple[Change, ...]
    spoiled: BoolArray

    def records(self) -> list[Record]:
        """Return the windows, which share their first and last samples."""
        long = self.scene.experiment.samples
        parts = [slice(k * long, (k + 1) * long + 1) for k in range(self.scene.windows)]
        return [Record(self.t[part], self.u[part], self.y[part]) for part in parts]


def run_of(scene: Scene) -> Run:
    """Simulate and measure a scene."""
    kind, experiment = KINDS[scene.kind], scene.experiment
    model, places = experiment.model, (PLANTS.index(scene.plant), list(KINDS).index(scene.kind))
    rng = np.random.default_rng([scene.seed, STREAM, *places, scene.rich])
    t: Array = experiment.interval * np.arange(experiment.samples * scene.windows + 1.0)
    x0, p, u = experiment.draw(rng, t, scene.rich)
    changes = jumps(rng, scene, p) if kind.jumps else ()
    course = moving(rng, scene, Course(Parameters.of(p, changes)))
    extra = UNMODELLED[scene.plant]

    def rates(now: float, x: Array, u: Array, p: Array) -> Sequence[float]:
        usual: Sequence[float] = model.dynamics(now, x, u, p)
        if not kind.missing:
            return usual
        return [a + kind.missing * b for a, b in zip(usual, extra(x, p), strict=True)]

    x, values = trajectory(rates, t, u, x0, course), course.at(t)
    outputs = [model.output(*each) for each in zip(t, x, u, values, strict=True)]
    sd = np.array(experiment.noise)
    y = np.array(outputs) + sd * noise(rng, kind.noise, (t.size, sd.size))
    spoiled = np.zeros(t.size, dtype=np.bool_)
    if kind.outliers:
        at, which = outliers(rng, scene)
        y[at, which] += rng.choice((-1.0, 1.0), at.size) * OUTLIER * sd[which]
        spoiled[at] = True
    return Run(scene, t, u, y, x, values, changes, spoiled)


def jumps(rng: np.random.Generator, scene: Scene, p: Array) -> tuple[Change, ...]:
    """Return one jump at a random time, in some runs two, of any parameters (q,)."""
    last, length = scene.windows - 1.0, scene.length
    times = [rng.uniform(QUIET, last)]
    if scene.seed % TWICE == 0:
        first = rng.uniform(QUIET, last - APART)
        times = [first, rng.uniform(first + APART, last)]
    values, changes = p.copy(), []
    for time in times:
        place = int(rng.integers(p.size))
        size = changed(rng, scene, place, float(values[place]), rng.uniform(*SIZES))
        changes.append(Change(time * length, place, size))
        values[place] += size
    return tuple(changes)


def changed(
    rng: np.random.Generator, scene: Scene, place: int, value: float, share: float
) -> float:
    """Return a change of a parameter by so much of its value, up or down, inside its box."""
    bounds = scene.experiment.model.parameters[place]
    room = ROOM * (bounds.upper - bounds.lower)
    inside = [
        sign * share * value for sign in (-1.0, 1.0)
        if bounds.lower + room < value * (1.0 + sign * share) < bounds.upper - room
    ]  # fmt: skip
    return float(rng.choice(inside))


def moving(rng: np.random.Generator, scene: Scene, course: Course) -> Course:
    """Return the course with the steady or oscillating change of a parameter that its kind has."""
    kind, length = KINDS[scene.kind], scene.length
    if not kind.oscillates and not kind.ramp:
        return course
    first = course.parameters.values[0]
    place = int(rng.integers(first.size))
    if kind.oscillates:
        phase, pace = rng.uniform(0.0, 2.0 * np.pi), 2.0 * np.pi * OSCILLATIONS / length
        return course._replace(
            place=place, factor=lambda t: 1.0 + AMPLITUDE * np.sin(pace * t + phase)
        )
    value = float(first[place])
    share = changed(rng, scene, place, value, SLOPE) / value
    begin = length * (QUIET + rng.uniform())
    end = begin + length * kind.ramp
    return course._replace(
        place=place,
        factor=lambda t: 1.0 + share * np.clip((t - begin) / (end - begin), 0.0, 1.0),
        corners=(begin, end),
    )


def outliers(rng: np.random.Generator, scene: Scene) -> tuple[IntArray, IntArray]:
    """Return samples and outputs that are outliers: one value in some of the windows."""
    samples, outputs = scene.experiment.samples, len(scene.experiment.noise)
    windows = np.flatnonzero(rng.random(scene.windows) < SPOILED)
    inside = rng.integers(1, samples, windows.size)
    return windows * samples + inside, rng.integers(outputs, size=windows.size)


def noise(rng: np.random.Generator, kind: str, shape: tuple[int, int]) -> Array:
    """Return noise (K, r) of standard deviation 1: white, first-order coloured, Student's t3."""
    if kind == 't3':
        return np.asarray(rng.standard_t(3, shape) / np.sqrt(3.0))
    white = rng.standard_normal(shape)
    if kind == 'coloured':
        fresh = np.sqrt(1.0 - CORRELATION**2)
        for k in range(1, len(white)):
            white[k] = CORRELATION * white[k - 1] + fresh * white[k]
    return white
