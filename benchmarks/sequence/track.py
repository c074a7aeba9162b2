"""One run solved: every window's estimate beside the truth."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from benchmarks.intervals import confidently_wrong
from benchmarks.sequence.contestants import CONTESTANTS, OURS, ours
from benchmarks.sequence.plants import Change, Run
from benchmarks.sequence.scenes import Scene, run_of
from obs_ros import Estimate, Outcome
from obs_ros.core.estimate import Jump
from obs_ros.core.model import names
from obs_ros.core.typing import Array, BoolArray, IntArray


class Track(NamedTuple):
    """The windows of one run (W of them), in boxes: parameters (W, q), end states (W, n).

    Errors are estimates less truth; a standard deviation that was withheld is NaN. `begin` and
    `end` (W,) are the windows' times in s, `jumps` the reports of each.
    """

    scene: Scene
    begin: Array
    end: Array
    p: Array
    p_error: Array
    p_sd: Array
    x: Array
    x_error: Array
    x_sd: Array
    outcomes: tuple[Outcome, ...]
    jumps: tuple[tuple[Jump, ...], ...]
    changes: tuple[Change, ...]
    event: float

    @property
    def alarms(self) -> IntArray:
        """Number of new jumps (W,) in each window."""
        return np.array([sum(jump.new for jump in jumps) for jumps in self.jumps])

    @property
    def mismatch(self) -> BoolArray:
        """Windows (W,) that say the model is wrong."""
        return np.array([outcome is Outcome.MODEL_MISMATCH for outcome in self.outcomes])

    @property
    def confidently_wrong(self) -> BoolArray:
        """Errors (W, q + n) above 3 sd and 2 % of the box though the sd was given."""
        return confidently_wrong(self.errors, self.deviations)

    @property
    def errors(self) -> Array:
        """Errors (W, q + n) of parameters and end states."""
        return np.hstack([self.p_error, self.x_error])

    @property
    def deviations(self) -> Array:
        """Standard deviations (W, q + n) of parameters and end states."""
        return np.hstack([self.p_sd, self.x_sd])

    def only(self, chosen: BoolArray) -> 'Track':
        """Return the windows chosen (W,), a mask."""
        places = np.flatnonzero(chosen)
        arrays: dict[str, Any] = {
            name: value[places]
            for name, value in self._asdict().items()
            if isinstance(value, np.ndarray)
        }
        return self._replace(
            **arrays,
            outcomes=tuple(self.outcomes[i] for i in places),
            jumps=tuple(self.jumps[i] for i in places),
        )


Cells = Mapping[tuple[str, str], Sequence[Track]]  # by cell and contestant


def tracked(
    scene: Scene,
    abutting: bool,
    contestant: str = OURS,
    factor: float | None = None,
    learn_noise: bool = False,
) -> Track:
    """Simulate a scene, solve its windows, abutting or not, and put the truth beside them.

    `factor` and `learn_noise`: see `ours`.
    """
    run = run_of(scene)
    period = run.plant.duration if abutting else run.plant.period
    if contestant == OURS:
        estimates = ours(run, period, factor, learn_noise)
    else:
        estimates = CONTESTANTS[contestant](run, period)
    return beside_truth(scene, run, estimates)


def beside_truth(scene: Scene, run: Run, estimates: Sequence[Estimate]) -> Track:
    """Return the estimates with their errors."""
    model, plant = run.plant.model, run.plant
    end = np.array([estimate.t1 for estimate in estimates])
    at_end = np.searchsorted(run.t, end - 0.5 * plant.step)
    parameters, states = names(model.parameters), names(model.states)
    low_p, low_x = ([v.lower for v in group] for group in (model.parameters, model.states))
    p = np.array([[e.parameters[name] for name in parameters] for e in estimates])
    x = np.array([[e.state[name] for name in states] for e in estimates])
    sd = np.array([[e.stddev[name] for name in (*parameters, *states)] for e in estimates])
    q = len(parameters)
    return Track(
        scene=scene,
        begin=np.array([estimate.t0 for estimate in estimates]),
        end=end,
        p=(p - low_p) / plant.width,
        p_error=(p - run.parameters.before(end)) / plant.width,
        p_sd=sd[:, :q] / plant.width,
        x=(x - low_x) / plant.state_width,
        x_error=(x - run.x[at_end]) / plant.state_width,
        x_sd=sd[:, q:] / plant.state_width,
        outcomes=tuple(estimate.outcome for estimate in estimates),
        jumps=tuple(estimate.jumps for estimate in estimates),
        changes=run.changes,
        event=run.event,
    )
