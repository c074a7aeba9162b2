"""What windows in a row have learned, as frozen data."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import get_args

from obs_ros.core.estimate import Estimate, Outcome
from obs_ros.core.model import Method, names
from obs_ros.core.typing import Array
from obs_ros.horizon.announcements import AnnouncementMemory
from obs_ros.horizon.arrival_cost import ArrivalMemory
from obs_ros.horizon.forecasts import BASES, FORECASTS, ForecastMemory
from obs_ros.horizon.found_jumps import Explained, JumpFound
from obs_ros.horizon.probation import ProbationMemory
from obs_ros.horizon.scatter import Alone
from obs_ros.horizon.stepping import SteppingMemory
from obs_ros.inference.assessment.lateness import Late
from obs_ros.inference.noise import NoiseMemory
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.process_noise import ProcessNoiseMemory
from obs_ros.samples.resolution import ResolutionMemory

# Of a longer window only the end is kept, and its steps are chosen anew: a bound on memory.
MOST_NODES = 20_000


@dataclass(frozen=True)
class PreviousWindow:
    """Values and trajectory of the newest usable window, from which the next one starts.

    `times` (K,) in s and `states` (K, n) are as in `Estimate`.
    """

    t0: float
    t1: float
    times: Array
    states: Array
    initial_state: Mapping[str, float]
    state: Mapping[str, float]
    parameters: Mapping[str, float]

    @classmethod
    def of(cls, estimate: Estimate) -> 'PreviousWindow':
        """Return what the next window needs of an estimate."""
        kept = slice(None) if estimate.times.size <= MOST_NODES else slice(-1, None)
        return cls(
            estimate.t0, estimate.t1, estimate.times[kept], estimate.states[kept],
            estimate.initial_state, estimate.state, estimate.parameters,
        )  # fmt: skip

    @property
    def estimate(self) -> Estimate:
        """An estimate with these values."""
        return Estimate(
            self.parameters, self.initial_state, self.state, {}, Outcome.CONVERGED, '', self.t0,
            self.t1, times=self.times, states=self.states,
        )  # fmt: skip


@dataclass(frozen=True)
class HorizonMemory:
    """All that one window hands on to the next; see `Knowledge` for each of them."""

    arrival_cost: ArrivalMemory
    noise: NoiseMemory
    stepping: SteppingMemory | None
    process_noise: ProcessNoiseMemory
    scatter: tuple[Alone, ...]
    level: float | None
    unsearched: int
    plain: Array | None
    forecasts: ForecastMemory
    announcements: AnnouncementMemory
    probation: ProbationMemory
    previous: PreviousWindow | None
    contradicted: frozenset[int]
    explained: Explained | None
    alone: tuple[bool, ...]
    resolutions: ResolutionMemory
    lateness: tuple[Late | None, ...]


def check_memory(memory: HorizonMemory, unknowns: Unknowns) -> None:
    """Raise ValueError where names, places, weights or lengths cannot be of these unknowns."""
    n, d = unknowns.n_states, unknowns.dimension
    parameters, model = range(n, d), unknowns.model
    for jump in memory.arrival_cost.jumps:
        _check_places('arrival_cost.jumps', jump.parameters, parameters)
        for _, places, found in jump.chances:
            _check_places('arrival_cost.jumps', places, parameters)
            _check_names('arrival_cost.jumps', [found] if found else [], unknowns)
    for entry in memory.arrival_cost.entries:
        for one in entry.components:
            _check('arrival_cost.entries: weights', one.weight > 0.0)
            _check_names('arrival_cost.entries', one.jumps, unknowns)
    told = memory.announcements
    _check_names('announcements', [event.found for event in told.events], unknowns)
    for event in told.events:
        _check('announcements: sizes', event.jump.sizes.keys() == event.jump.stddev.keys())
    _check('announcements: rates', told.rates.keys() <= set(unknowns.names[n:]))
    _check_places('contradicted', memory.contradicted, range(d))
    _check('alone', len(memory.alone) == d - n)
    if (explained := memory.explained) is not None:
        layout = explained.layout
        fits = layout.dimension == d and layout.size == explained.point.size
        _check('explained: point', fits)
        for event_places in layout.events:
            _check_places('explained', event_places, parameters)
    if (steps := memory.stepping) is not None:
        _check('stepping: method', steps.method in get_args(Method))
        _check('stepping: steps', steps.h.size == steps.t.size - 1 and bool((steps.h > 0.0).all()))
    if (previous := memory.previous) is not None:
        _check('previous: times', previous.times.size > 0)
        for values in (previous.state, previous.initial_state):
            _check('previous: states', tuple(values) == names(model.states))
        _check('previous: parameters', tuple(previous.parameters) == names(model.parameters))
    _check_forecasts(memory.forecasts)
    _check_resolutions(memory.resolutions, len(model.outputs))


def _check_forecasts(memory: ForecastMemory) -> None:
    horizons = len(FORECASTS.horizons)
    _check('forecasts: lanes', len(memory.lanes) == len(BASES) * len(memory.pending))
    _check('forecasts: judged', len(memory.judged) == horizons)
    for one in memory.pending:
        _check('forecasts: pending', len(one.judged) == horizons)


def _check_resolutions(memory: ResolutionMemory, outputs: int) -> None:
    for each in (memory.seen, memory.steps, memory.noises):
        _check('resolutions', len(each) == outputs)
    _check_places('resolutions', memory.unknown, range(outputs))


def _check(where: str, fits: bool) -> None:
    if not fits:
        raise ValueError(f'{where} cannot be of this model')


def _check_places(where: str, places: Iterable[int], allowed: Collection[int]) -> None:
    _check(f'{where}: places', all(place in allowed for place in places))


def _check_names(where: str, jumps: Iterable[JumpFound], unknowns: Unknowns) -> None:
    known = set(unknowns.names[unknowns.n_states :])
    _check(f'{where}: names', all(jump.names <= known for jump in jumps))
