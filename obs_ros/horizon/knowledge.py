"""Knowledge of the windows so far: all that one hands on to the next, and that a restart keeps.

A `HorizonMemory` is frozen data: a horizon that recalls it goes on with the same bits as the one
that it is of. Time that nobody looked at is a gap between two windows, as within one run:
parameters walk through it, and the states at the start of the next window are free.
"""

import numpy as np

from obs_ros.core.estimate import Estimate
from obs_ros.core.model import names
from obs_ros.core.plain_data import Shapes
from obs_ros.core.typing import Array
from obs_ros.horizon.announcements import Announcements
from obs_ros.horizon.arrival_cost import ArrivalCost
from obs_ros.horizon.forecasts import BASES, FORECASTS, Forecasts
from obs_ros.horizon.found_jumps import Explained
from obs_ros.horizon.horizon_memory import HorizonMemory, PreviousWindow, check_memory
from obs_ros.horizon.probation import Probation
from obs_ros.horizon.scatter import Scatter
from obs_ros.horizon.solver import Solver
from obs_ros.horizon.stepped_windows import SteppedWindows
from obs_ros.inference.assessment.lateness import LateSignals
from obs_ros.inference.noise import Noise
from obs_ros.inference.outlier_count import OutlierCount
from obs_ros.inference.process_noise import LearnedProcessNoise
from obs_ros.samples.resolution import Resolutions


class Knowledge:
    """Noise, arrival cost, process noise, jumps, forecasts and warm start of windows in a row.

    With `learn_noise` the noise that is given is only a starting value.
    """

    def __init__(self, solver: Solver, *, learn_noise: bool = False) -> None:
        self._solver = solver
        outputs = solver.model.outputs
        self._arrival_cost = ArrivalCost(solver.unknowns)
        self._noise = Noise(solver.noise, names(outputs), learn_noise)
        self._given = np.full(len(outputs), np.nan) if learn_noise else solver.given_noise
        self._stepped = SteppedWindows(solver)
        self._process_noise = LearnedProcessNoise()
        self._scatter = Scatter()
        self._level: float | None = None  # see `Earlier`
        self._unsearched = 0  # windows since the last search
        self._plain: Array | None = None  # the last optimum (d,) without process noise
        self.forecasts = Forecasts()
        self._announcements = Announcements()
        self._probation = Probation()
        self._previous: Estimate | None = None
        self._first = True  # whether no window has been solved
        self._contradicted: set[int] = set()  # places of given priors that some window contradicts
        self._explained: Explained | None = None  # the previous window
        # Parameters that some window has determined by itself.
        self._alone = np.zeros(solver.unknowns.dimension - solver.unknowns.n_states, dtype=np.bool_)
        self.outliers = OutlierCount(names(outputs))
        self._resolutions = Resolutions(outputs)
        self._lateness = LateSignals()
        self.stuck, self.huge = 0, 0  # values that repeat, and that no signal of a window can have

    @property
    def memory(self) -> HorizonMemory | None:
        """All that was learned, which nothing changes later; None before the first window."""
        if self._first:
            return None
        return HorizonMemory(
            arrival_cost=self._arrival_cost.memory,
            noise=self._noise.memory,
            stepping=self._stepped.memory,
            process_noise=self._process_noise.memory,
            scatter=self._scatter.memory,
            level=self._level,
            unsearched=self._unsearched,
            plain=self._plain,
            forecasts=self.forecasts.memory,
            announcements=self._announcements.memory,
            probation=self._probation.memory,
            previous=None if self._previous is None else PreviousWindow.of(self._previous),
            contradicted=frozenset(self._contradicted),
            explained=self._explained,
            alone=tuple(self._alone.tolist()),
            resolutions=self._resolutions.memory,
            lateness=self._lateness.memory,
        )

    def recall(self, memory: HorizonMemory) -> None:
        """Go on as if the windows of another one, of the same model and settings, were one's own.

        Raises ValueError for a memory that cannot be of this model.
        """
        check_memory(memory, self._solver.unknowns)
        self._arrival_cost.recall(memory.arrival_cost)
        self._noise.recall(memory.noise)
        self._stepped.recall(memory.stepping)
        self._process_noise.recall(memory.process_noise)
        self._scatter.recall(memory.scatter)
        self._level, self._unsearched = memory.level, memory.unsearched
        self._plain = memory.plain
        self.forecasts.recall(memory.forecasts)
        self._announcements.recall(memory.announcements)
        self._probation.recall(memory.probation)
        self._previous = None if memory.previous is None else memory.previous.estimate
        self._first = False
        self._contradicted = set(memory.contradicted)
        self._explained = memory.explained
        self._alone = np.array(memory.alone, dtype=np.bool_)
        self._resolutions.recall(memory.resolutions)
        self._lateness.recall(memory.lateness)

    @property
    def shapes(self) -> Shapes:
        """The shapes that the arrays of a memory have."""
        unknowns, model = self._solver.unknowns, self._solver.model
        sizes = {
            'd': unknowns.dimension,
            'q': unknowns.dimension - unknowns.n_states,
            'n': len(model.states),
            'p': len(model.parameters),
            'v': len(model.variables),
            'r': len(model.outputs),
            'H': len(FORECASTS.horizons),
            'B': len(BASES),
        }
        return Shapes(SHAPES, sizes, NOT_FINITE)


SHAPES = {
    'ArrivalMemory.drifts': 'q',
    'WindowPosterior.mean': 'q',
    'WindowPosterior.covariance': 'q q',
    'Component.mean': 'q',
    'Component.covariance': 'q q',
    'Leftover.variances': 'r',
    'ProcessNoise.walks': 'v',
    'ProcessNoise.noise': 'r',
    'SteppingMemory.t': 'K',
    'SteppingMemory.h': 'L',
    'Alone.mean': 'q',
    'Alone.deviation': 'q',
    'HorizonMemory.plain': 'd',
    'Ends.state': 'n',
    'Ends.parameters': 'p',
    'Pending.held': 'r',
    'Pending.noise': 'r',
    'Pending.model': 'H B r',
    'Pending.hold': 'H r',
    'Pending.count': 'H r',
    'Judged.model': 'B r',
    'Judged.hold': 'r',
    'Judged.count': 'r',
    'Judged.noise': 'r',
    'PreviousWindow.times': 'K',
    'PreviousWindow.states': 'K n',
    'Explained.point': 'D',
}

# What a window may leave undetermined, and forecasts that ran away. All else is finite.
NOT_FINITE = frozenset({
    'Jump.time_stddev', 'Jump.stddev', 'Jump.probability', 'JumpFound.deviation', 'Size.stddev',
    'Size.spread', 'Whiteness.correlation', 'Whiteness.deviations', 'SteppingMemory.error',
    'Alone.mean', 'Alone.deviation', 'HorizonMemory.level', 'ForecastMemory.time', 'Ends.state',
    'Pending.held', 'Pending.noise', 'Pending.model', 'Pending.hold', 'Judged.model', 'Judged.hold',
    'Judged.noise', 'ResolutionMemory.newest',
})  # fmt: skip
