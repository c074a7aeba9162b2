"""Process noise of a window: walks of its states, found by maximum likelihood.

The states of a real plant are pushed about by all that its model leaves out,

    dx = f(t, x, u, p) dt + diag(walk) dW,    y_k = h(t_k, x_k, u_k, p) + v_k,    v_k ~ N(0, R).

Along one candidate the extended Kalman filter gives gains, innovations e and their variances S, see
`FilterPass`. Walks and R minimise -2 log p(y) = sum log S + e^2 / S, the likelihood of prediction
errors (Ljung 1999, section 7.4; Kristensen, Madsen & Jorgensen 2004). With its gains frozen the
filter is a rollout that measurements correct, and its scaled innovations are residuals like any
others: candidates are searched as without process noise, gains and candidate renewed by turns.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from obs_ros.core.model import Model, names
from obs_ros.core.saturation import unsaturated
from obs_ros.core.typing import Array, IntArray
from obs_ros.inference.noise import LEARNING, noise_guess
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.window_state import WindowState
from obs_ros.integration.linear_path import LinearPath


@dataclass(frozen=True)
class ProcessNoiseSettings:
    """Limits in learning process noise.

    - `least_noise`: of an output's standard deviation, below which measurement noise never falls:
      without it the filter would follow every sample;
    - `start`: share of a state's spread along the window that its first walk makes up in the
      window's length;
    - `loose`: times that, for a start of states that follow the outputs;
    - `reach`: times above and below its start that a walk is sought in;
    - `rounds`: of renewing noise and candidate by turns, until -2 log likelihood falls by less than
      `gain`;
    - `apart`: deviations of the noise by which the deviation of an innovation may exceed the range
      of what was measured: linearised, a filter is lost there;
    - `restricted`: of -2 log likelihood and for each unknown, by which noise with the unknowns
      integrated out may be less likely along them;
    - `tolerance`: of -2 log likelihood in a round; at 0.01 parameters ended 0.003 deviations apart
      where noise hardly counts beside walks, and at 0.001 no later;
    - `settled`: windows whose walks tell what a jump is;
    - `usual`: latest windows, of which half must have had process noise for it to be expected;
    - `polish`: iterations of the local search for the candidate in a round.
    """

    least_noise: float = 2e-3
    start: float = 0.3
    loose: float = 30.0
    reach: float = 1e4
    rounds: int = 6
    gain: float = 0.1
    apart: float = 10.0
    restricted: float = 2.0
    tolerance: float = 0.001
    settled: int = 4
    usual: int = 6
    polish: int = 20


SETTINGS = ProcessNoiseSettings()
ProcessNoiseMode = Literal['off', 'auto', 'given']
MODES: tuple[str, ...] = get_args(ProcessNoiseMode)
STEP = 1e-5  # of a logarithm, for differences


@dataclass(frozen=True)
class ProcessNoise:
    """Walks (n + q,) in the variables' units per root of a second, and deviations (r,) of noise."""

    walks: Array
    noise: Array

    def scaled(self, ratio: float) -> 'ProcessNoise':
        """Return all of it `ratio` times as large: a filter's gains stay."""
        return ProcessNoise(ratio * self.walks, ratio * self.noise)

    def words(self, model: Model) -> str:
        """Say which states are pushed about, by how much, and which parameters drift."""
        drifting = self.drifting(model)
        if drifting:
            walks = dict(zip(names(model.variables), self.walks, strict=True))
            given = ', '.join(f'`walk.{name}: {walks[name]:.2g}`' for name in drifting)
            return f'{", ".join(drifting)} drifts: give {given}'
        found = []
        for variable, walk in zip(model.states, self.walks, strict=False):
            if walk > 0.0:
                unit = '' if variable.unit == '1' else f' {variable.unit}'
                found.append(f'{variable.name} by {walk:.2g}{unit}/sqrt(s)')
        return 'pushed about by what the model leaves out: ' + ', '.join(found) if found else ''

    def drifting(self, model: Model) -> tuple[str, ...]:
        """Return the parameters that walk though the model does not say so."""
        walks = self.walks[len(model.states) :]
        return tuple(
            variable.name
            for variable, walk in zip(model.parameters, walks, strict=True)
            if walk > 0.0 and variable.walk is None
        )


@dataclass(frozen=True)
class ProcessNoiseMemory:
    """Process noise of windows, whether each was sound, and which of the latest had any."""

    recent: tuple[ProcessNoise, ...]
    sound: tuple[bool, ...]
    had: tuple[bool, ...]


class LearnedProcessNoise:
    """Process noise of the latest windows that had any: the medians are where the next one begins.

    A walk that most windows lack is 0.
    """

    def __init__(self, remembered: int = LEARNING.remembered) -> None:
        self._recent: deque[ProcessNoise] = deque(maxlen=remembered)
        self._sound: deque[bool] = deque(maxlen=remembered)
        self._had: deque[bool] = deque(maxlen=SETTINGS.usual)

    @property
    def memory(self) -> ProcessNoiseMemory:
        """All that was learned."""
        return ProcessNoiseMemory(tuple(self._recent), tuple(self._sound), tuple(self._had))

    def recall(self, memory: ProcessNoiseMemory) -> None:
        """Know what another one learned, of the same model."""
        self._recent = deque(memory.recent, self._recent.maxlen)
        self._sound = deque(memory.sound, self._sound.maxlen)
        self._had = deque(memory.had, self._had.maxlen)

    def add(self, found: ProcessNoise, sound: bool = True) -> None:
        """Remember the process noise of a window; `sound` if nothing else is left to explain."""
        if not (np.isfinite(found.walks).all() and np.isfinite(found.noise).all()):
            return
        self._recent.append(found)
        self._sound.append(sound)

    def note(self, had: bool) -> None:
        """Note whether a window had process noise."""
        self._had.append(had)

    @property
    def latest(self) -> bool:
        """Whether the latest window had process noise."""
        return bool(self._had) and self._had[-1]

    @property
    def usual(self) -> bool:
        """Whether half of the latest windows, or more, had process noise, one calm one aside."""
        return 2 * sum(self._had) >= len(self._had) - 1

    @property
    def settled(self) -> bool:
        """Whether enough sound windows tell how far states walk to set a jump apart from it."""
        return sum(self._sound) >= SETTINGS.settled

    @property
    def pooled(self) -> ProcessNoise | None:
        """The medians; None as long as no window had process noise."""
        if not self._recent:
            return None
        walks = np.median([one.walks for one in self._recent], axis=0)
        return ProcessNoise(walks, np.median([one.noise for one in self._recent], axis=0))


def groups_of(model: Model) -> list[IntArray]:
    """Return the places of states that share one walk: those of one unit."""
    units = [variable.unit for variable in model.states]
    return [np.flatnonzero([u == unit for u in units]) for unit in dict.fromkeys(units)]


def first_guess(
    window: WindowState, z: Array, given: Array, groups: Sequence[IntArray]
) -> ProcessNoise:
    """Return walks that would move the states as far as they spread, and noise by its bends.

    Parameters walk as the model says: in their units, at the values that they have at z (d,).
    """
    states = window.objective.trajectory(z)[0]
    spread = states.std(axis=0) + 1e-6 * np.abs(states).max(axis=0) + 1e-12
    walks = np.zeros(len(window.objective.unknowns.model.variables))
    for group in groups:
        walks[group] = SETTINGS.start * spread[group].max() / np.sqrt(window.duration)
    places, own = parameter_walks(window.objective.unknowns, z)
    walks[places] = own
    values = unsaturated(window.objective.unknowns.model.outputs, window.record.y)
    guessed = np.array([noise_guess(y) for y in values.T])
    noise = np.where(np.isfinite(given), given, np.maximum(guessed, least_noise(window)))
    return ProcessNoise(walks, noise)


def parameter_walks(unknowns: Unknowns, z: Array) -> tuple[IntArray, Array]:
    """Return which of the n + q variables are parameters that walk, and their walks."""
    n = unknowns.n_states
    walking = np.flatnonzero(np.isfinite(unknowns.walks))
    return unknowns.index[n + walking], (unknowns.walks * unknowns.scale.slopes(z)[n:])[walking]


def least_noise(window: WindowState) -> Array:
    """Return the least standard deviations (r,) that measurement noise may have.

    No sensor is more exact than it rounds.
    """
    grid = window.objective.grid
    spread = np.array([np.std(y[w > 0.0]) if w.any() else 1.0
                       for y, w in zip(grid.y.T, grid.weight.T, strict=True)])  # fmt: skip
    return np.maximum(SETTINGS.least_noise * np.where(spread > 0.0, spread, 1.0), grid.rounding)


def most_likely(
    path: LinearPath,
    start: ProcessNoise,
    groups: Sequence[IntArray],
    given: Array,
    least: Array,
) -> ProcessNoise:
    """Return the most likely noise along a linearised window."""
    free = np.flatnonzero(~np.isfinite(given))
    count = len(groups)
    if not count and not free.size:
        return start

    def noises(theta: Array) -> tuple[Array, Array]:
        walks = np.repeat(start.walks[:, None], theta.shape[1], axis=1)
        noise = np.repeat(start.noise[:, None], theta.shape[1], axis=1)
        for k, group in enumerate(groups):
            walks[group] = np.exp(theta[k])
        noise[free] = np.exp(theta[count:])
        return walks, noise

    def criterion(theta: Array) -> tuple[float, Array]:
        m = theta.size
        lanes = np.repeat(theta[:, None], 1 + m, axis=1)
        lanes[np.arange(m), 1 + np.arange(m)] += STEP
        found = path.neg2_log_likelihood(*noises(lanes))
        if not np.isfinite(found).all():
            return 1e300, np.zeros(m)
        return float(found[0]), (found[1:] - found[0]) / STEP

    noise = np.maximum(start.noise[free], least[free])
    theta = np.log(np.concatenate([[start.walks[group[0]] for group in groups], noise]))
    reach = np.log(SETTINGS.reach)
    bounds = [(t - reach, t + reach) for t in theta[:count]]
    bounds += [(np.log(low), np.log(low / SETTINGS.least_noise)) for low in least[free]]
    from scipy.optimize import minimize

    solved = minimize(
        criterion, theta, jac=True, method='SLSQP', bounds=bounds, tol=SETTINGS.tolerance
    )
    walks, noise = noises(solved.x[:, None])
    return ProcessNoise(walks[:, 0], noise[:, 0])


def prepare() -> None:
    """Import the minimisation of the likelihood, which takes as long as most of the package."""
    import scipy.optimize  # noqa: F401


def estimated_parameters(unknowns: Unknowns) -> IntArray:
    """Return which of the model's q parameters are estimated."""
    return np.asarray(unknowns.index[unknowns.n_states :] - len(unknowns.model.states))
