"""Probation: sensors that are stuck, and windows that follow one that the model cannot explain."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.core.estimate import Estimate, Outcome
from obs_ros.core.model import Model, names
from obs_ros.core.record import Record
from obs_ros.core.saturation import unsaturated
from obs_ros.core.typing import Array
from obs_ros.optimization.memetic import MemeticSettings
from obs_ros.samples.resolution import Resolutions
from obs_ros.samples.stuck_sensor import stuck, words

EARNED = 20  # windows in a row that fit: fewer happen by chance near rest
SKILLED = 4  # in a row whose forecasts beat holding the last value: these are no imitation


@dataclass(frozen=True)
class Sound:
    """A window without what stuck sensors repeat: None if nothing else is left of it.

    `repeated` counts values, `said` names their sensors; `steps` are figures of those that sensors
    were found to round to. `stale`: one of the sensors has not said anything else since.
    """

    record: Record | None
    repeated: int
    said: str
    steps: Mapping[str, float] = field(default_factory=dict)
    stale: bool = False

    def told(self, estimate: Estimate) -> Estimate:
        """Return the estimate of the window with what is known of its sensors."""
        if self.steps:
            estimate = replace(estimate, figures={**estimate.figures, **self.steps})
        if not self.repeated:
            return estimate
        outcome = Outcome.STALE_OUTPUT if self.stale and estimate.usable else estimate.outcome
        return replace(estimate, outcome=outcome, message=f'{self.said}; {estimate.message}')


def without_stuck(
    model: Model,
    record: Record,
    given: Mapping[str, float],
    scale: Array | None,
    resolutions: Resolutions | None = None,
) -> Sound:
    """Take out what a stuck sensor repeats, and let `resolutions` learn from the others.

    `scale` (r,) is the noise, given or learned; None while some of it is known only as `given`.
    """
    noisy = np.array([name in given for name in names(model.outputs)])
    if scale is not None:
        # Below that the noise is but rounding, as in a simulation.
        noisy = scale > MemeticSettings.negligible * np.nanmax(
            np.abs(record.y), axis=0, initial=0.0
        )
    values = unsaturated(model.outputs, record.y)
    steps: Mapping[str, float] = {}
    if resolutions is not None:
        resolutions.note_window(record.t, values)
        resolutions.learn()
        steps = resolutions.figures
    noise = np.array([given.get(name, np.nan) for name in names(model.outputs)])
    repeated = stuck(values, noisy, resolutions=resolutions, noise=noise)
    if not repeated.any():
        return Sound(record, 0, '', steps)
    said = words(model, np.flatnonzero(repeated.any(axis=0)))
    left = np.where(repeated, np.nan, record.y)
    sound = None if np.isnan(left).all() else record.with_outputs(left)
    newest = np.where(np.isfinite(record.y), np.arange(record.t.size)[:, None], -1).max(axis=0)
    stale = bool(repeated[newest, np.arange(newest.size)].any())
    return Sound(sound, int(repeated.sum()), said, steps, stale)


@dataclass(frozen=True)
class ProbationMemory:
    """Whether a model is trusted, and what it has earned so far; see `Probation`."""

    trusted: bool
    since: float | None
    earned: int
    foretold: int


class Probation:
    """Withholds confidence from a model that the very first windows contradict.

    Near rest, parameters can imitate nearly anything: an input in other units, say. So trust has to
    be earned then, by `windows` in a row that fit. Once trusted, a window that does not fit is an
    event of its own, and casts no doubt on others.
    """

    def __init__(self, windows: int = EARNED, skilled: int = SKILLED) -> None:
        self._windows, self._skilled = windows, skilled
        self._trusted = False
        self._since: float | None = None  # the end (s) of the last window that did not fit
        self._earned = self._foretold = 0

    @property
    def memory(self) -> ProbationMemory:
        """What was earned so far."""
        return ProbationMemory(self._trusted, self._since, self._earned, self._foretold)

    def recall(self, memory: ProbationMemory) -> None:
        """Trust the model as another one did."""
        self._trusted, self._since = memory.trusted, memory.since
        self._earned, self._foretold = memory.earned, memory.foretold

    def judge(
        self, estimate: Estimate, fits: bool, skill: float | None = None, *, given: bool = True
    ) -> Estimate:
        """Return the estimate as it is to be believed; `fits` by the model and noise alone.

        Process noise contradicts the model too. With it, the `skill` of forecasts shows that the
        model is no imitation; until then the estimate keeps no standard deviations if the noise
        that it contradicts was `given`.
        """
        if self._trusted:
            return estimate
        if skill is not None:
            self._foretold = self._foretold + 1 if skill > 0.0 else 0
        elif not fits:
            self._foretold = 0
        if not fits and not given and (skill or 0.0) > 0.0:
            return estimate  # nothing that is known is contradicted
        if not fits:
            self._since, self._earned = estimate.t1, 0
            self._trusted = self._foretold >= self._skilled
            if self._trusted or skill is None:
                return estimate
            left = self._skilled - self._foretold
            return _withheld(
                estimate,
                Outcome.APPROXIMATE if skill > 0.0 else estimate.outcome,
                'check the noise and units, or wait: standard deviations follow after '
                f'{left} more windows whose forecasts beat holding the last value',
            )
        self._earned += 1
        self._trusted = self._since is None or self._earned > self._windows
        if self._trusted:
            return estimate
        return _withheld(
            estimate,
            Outcome.MODEL_MISMATCH,
            'check units, model and fixed values, or reset if what disturbed it is over: the '
            f'window that ended at {self._since:g} s contradicted the model; this one fits',
        )


def withheld_by_push(estimate: Estimate) -> Estimate:
    """Return an estimate with process noise that earlier windows had not, without deviations.

    What pushes the states all at once may be a jump that was not found.
    """
    return _withheld(
        estimate,
        Outcome.APPROXIMATE if estimate.outcome is Outcome.CONVERGED else estimate.outcome,
        'look for a fault, or a parameter that jumped: process noise explains this window, which '
        'earlier ones did not have; standard deviations follow when it stays',
    )


def _withheld(estimate: Estimate, outcome: Outcome, why: str) -> Estimate:
    """Return the estimate without jumps and deviations, and why."""
    message = f'{why} ({estimate.message})'
    return replace(estimate.without_deviations(), outcome=outcome, message=message, jumps=())
