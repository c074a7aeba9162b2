"""The common part of observers that take one step for each output."""

import math
import time
from collections.abc import Iterable, Mapping
from typing import Any, ClassVar

import numpy as np

from obs_ros.core import estimated_delays
from obs_ros.core.estimate import Estimate, Outcome, normal_intervals
from obs_ros.core.model import Model, checked_noise, names
from obs_ros.core.periods import periods, within
from obs_ros.core.record import Sample
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.integration.backends import Backend, check_backend
from obs_ros.integration.live_steps import figures_of, live_stepper, prepare
from obs_ros.integration.path import Path
from obs_ros.integration.stepper import Stepper
from obs_ros.models import load_model
from obs_ros.observers import settings as table
from obs_ros.observers.innovation_gate import Admission, expected_outputs, root_mean_square
from obs_ros.observers.output_intake import Instant, OutputIntake, outputs_at
from obs_ros.observers.rehearsal import rehearsed
from obs_ros.observers.start import initial_values, kept_bounds
from obs_ros.samples.gate import GateSettings
from obs_ros.samples.stuck_sensor import Repeats, words
from obs_ros.samples.successive_outputs import SuccessiveOutputs


class RecursiveObserver:
    """Takes one step for each output, in the thread that absorbs.

    A subclass has `Settings` (see `setting`) and these hooks:

    - `_start(now)` begins at an output: x (n,) and p (q,) hold the initial values, `rng` is new;
    - `_step(before, now, path)` goes from one output to the next, the inputs being those of `path`.

    Both leave the estimate in `x`, `p`, `stddev` (n + q,), `innovation` (r,), the measured outputs
    less those expected, `innovation_stddev` (r,) and `figures`; in the last four NaN stands for
    unknown numbers. All are written in place. Outputs that the gate rejects come as NaN, or as
    they were expected to an observer that needs them. `prepare` compiles the code of both, as it
    lets a twin observe `rehearsal` made-up outputs.

    Values that are not finite never leave: the observer starts again from its initial values.

    Parameters
    ----------
    model : a Model, a built-in model's name, or `module:ATTRIBUTE`.
    parameters, states : names to estimate; default all parameters and all states. The others
        have their fixed or nominal value: parameters always, states at the start.
    fixed : values of names that are not estimated.
    bounds : (lower, upper) by name, instead of the model's.
    noise : standard deviation by output, in its unit.
    initial : values by name to start from; default a prior's mean, the nominal value or mid of box.
    seed : of everything random; the same seed and samples give the same bits.
    backend : `numba` or `numpy`; None takes Numba where it is installed.
    settings : those of the class, see `Settings`.

    Raises ValueError for anything wrong with these, with the name and the value, and for a model
    that does not suit.
    """

    immediate: ClassVar[bool] = True
    Settings: ClassVar[type[table.Settings]] = table.Settings
    estimates_parameters: ClassVar[bool] = True  # False: they are given, all of them
    takes_discrete: ClassVar[bool] = False  # True: models without rates, too
    settings_decide: ClassVar[bool] = False  # True: `suits` is about those by default
    gates_itself: ClassVar[bool] = False  # by the covariance that it has
    needs_outputs: ClassVar[bool] = False  # all of them, at each step
    rehearsal: ClassVar[int] = 3  # outputs, until all is compiled
    difference: ClassVar[float] = 6e-6  # of a range, in central differences: eps^(1/3)
    reasons: ClassVar[tuple[str, ...]] = ()  # for which a subclass counts more

    def __init__(
        self,
        model: Model | str,
        *,
        parameters: Iterable[str] | None = None,
        states: Iterable[str] | None = None,
        fixed: Mapping[str, float] | None = None,
        bounds: Mapping[str, tuple[float, float]] | None = None,
        noise: Mapping[str, float] | None = None,
        initial: Mapping[str, float] | None = None,
        seed: int = 0,
        backend: Backend | None = None,
        **settings: Any,
    ) -> None:
        self.model = table.stamped(load_model(model), type(self).__name__, self.takes_discrete)
        estimated_delays.refuse(names(self.model.parameters), type(self).__name__)
        if not self.settings_decide:
            self.suits(self.model)
        self.settings: Any = table.settings_of(self.Settings, settings)
        if not self.estimates_parameters:
            if parameters is not None and tuple(parameters):
                raise ValueError(f'{type(self).__name__} estimates states only, no parameters')
            parameters = ()
        self.unknowns = Unknowns.of(self.model, parameters, states, fixed, bounds)
        self.lower, self.upper = kept_bounds(self.model, bounds)
        self.noise = checked_noise(self.model, noise)
        self.initial = initial_values(self.unknowns, initial or {})
        self.backend: Backend | None = backend
        check_backend(backend)
        random_generator(seed)  # refuses a bad one now
        self._seed = seed
        self._arguments = {
            'parameters': parameters, 'states': states, 'fixed': fixed, 'bounds': bounds,
            'noise': noise, 'initial': initial, 'seed': seed, 'backend': backend, **settings,
        }  # fmt: skip
        self._names = names(self.model.states), names(self.model.parameters)
        self._unknowns, self._outputs = names(self.model.variables), names(self.model.outputs)
        n, q, r = map(len, (*self._names, self._outputs))
        self.x, self.p, self.stddev = np.empty(n), np.empty(q), np.empty(n + q)
        self.innovation, self.innovation_stddev = np.empty((2, r))
        own = {} if self.gates_itself else self.noise
        admission = Admission.of(self.model.outputs, self.settings, own)
        self._intake = OutputIntake(self.model, admission, filled=self.needs_outputs)
        self._fixed_parameters = np.setdiff1d(np.arange(n, n + q), self.unknowns.index)
        self.figures: dict[str, float] = {}
        self._before: Instant | None = None
        self._live: Stepper | None = None
        self._due = self._diverged = self._blind = False
        self._taken, self._step_time = 0, 0.0
        self._counts = dict.fromkeys(('reset_non_finite', *self.reasons, 'skipped'), 0)
        # Outputs whose noise is known cannot stand still; see `stuck_sensor`.
        self._noise = np.array([self.noise.get(name, math.nan) for name in self._outputs])
        self._repeats = Repeats.of(self.model, self._noise.tolist())
        reach = GateSettings(reach=self.settings.longest_gap).within_steps(self.model)
        self._samples = SuccessiveOutputs(self.model, reach, self._repeats)
        self._periods = periods(self.model.states), periods(self.model.outputs)
        self._forget()

    @classmethod
    def suits(cls, model: Model) -> None:
        """Raise ValueError, with the reason, if the observer is not for such a model."""

    def _start(self, now: Instant) -> None:
        """Begin at an output, from the initial values in x and p."""
        raise NotImplementedError

    def _step(self, before: Instant, now: Instant, path: Path) -> None:
        """Go from the output before to the one now, the inputs being those of the path."""
        raise NotImplementedError

    @property
    def stepper(self) -> Stepper:
        """The model's steps; compiled at the first call, which may take some seconds."""
        if self._live is None:
            stddev = self.stddev[: self.x.size]
            self._live = live_stepper(self.model, self.backend, self._noise, stddev)
        return self._live

    def prepare(self) -> float:
        """Compile everything that is not compiled yet; return the seconds that it took."""
        begin = time.perf_counter()
        twin = type(self)(self.model, **self._arguments)
        prepare(self.model, self.backend)
        gap = self.settings.longest_gap or math.inf
        for sample in rehearsed(self.model, twin.x, twin.p, self.rehearsal, gap):
            twin.absorb(sample)
        return time.perf_counter() - begin

    def prepare_more(self) -> bool:
        """See `Observer.prepare_more`."""
        return False

    def absorb(self, sample: Sample) -> bool:
        """Take a sample, and one step if it is an output; return whether an estimate is due."""
        if self._samples.push(sample):
            self._forget()
        outputs = self._samples.due
        for stamp, y in outputs:
            self._counts['skipped'] += self._due
            self._advance(stamp, y)
        # With every sensor stuck no step is taken, and the estimate has to say so.
        all_stuck = len(self._repeats.stuck) == len(self._outputs)
        self._blind = not outputs and sample.y is not None and self._taken > 0 and all_stuck
        self._due |= self._blind
        return bool(outputs) or self._blind

    def estimate(self, deadline: float | None = None) -> Estimate | None:
        """Return the estimate at the newest output; None if it was returned before."""
        if not self._due:
            return None
        self._due = False
        assert self._before is not None
        now, (states, parameters) = self._before, self._names
        x = within(self.x, self._periods[0]).tolist()
        innovation = within(self.innovation, self._periods[1]).tolist()
        p, stddev, spread = (a.tolist() for a in (self.p, self.stddev, self.innovation_stddev))
        if self._diverged or self._blind:
            x, p, stddev = ([math.nan] * len(each) for each in (x, p, stddev))
        outcome = Outcome.DIVERGED if self._diverged else Outcome.CONVERGED
        message = f'{self._remark}{self._taken} outputs since the start'
        if self._diverged:
            message = f'check the model, the bounds and the start: {message}'
        if stuck := self._repeats.stuck:
            outcome = Outcome.STALE_OUTPUT
            message = f'{words(self.model, stuck)}; {message}'
        state, found = dict(zip(states, x, strict=True)), dict(zip(parameters, p, strict=True))
        spreads = dict(zip(self._unknowns, stddev, strict=True))
        return Estimate(
            parameters=found,
            initial_state=state,
            state=state,
            stddev=spreads,
            interval=normal_intervals(state | found, spreads),
            outcome=outcome,
            message=message,
            t0=now.t,
            t1=now.t,
            residual_rms=root_mean_square(innovation),
            stamp=now.stamp,
            innovation=dict(zip(self._outputs, innovation, strict=True)),
            innovation_stddev=dict(zip(self._outputs, spread, strict=True)),
            solve_time=self._step_time,
            figures={**figures_of(self._live), **self.figures, **self._repeats.resolutions.figures},
            last_outlier=self._intake.last_outlier,
        )

    def inherit(self, other: 'RecursiveObserver') -> bool:
        """Take nothing over from the observer that this one replaces: it has a start of its own."""
        return False

    def reset(self) -> None:
        """Forget all samples and estimates, but not the counts."""
        self._samples.reset()
        self._forget()

    @property
    def counts(self) -> Mapping[str, int]:
        """Numbers of samples dropped, mended or skipped so far, by reason."""
        return {**self._samples.counts, **self._intake.counts, **self._counts}

    @property
    def collected(self) -> None:
        """There are no windows."""
        return None

    @property
    def last_break(self) -> str | None:
        """The last break of the samples' timeline, in words."""
        return self._samples.gate.last_break

    def _remark_on(self, reason: str, words: str) -> None:
        """Count something that went wrong in a step, and say so from now on."""
        self._counts[reason] += 1
        self._remark = f'{words}; '

    def _advance(self, stamp: int, y: Array) -> None:
        """Take the step to an output."""
        begin = time.perf_counter()
        before = self._before
        path = self._samples.inputs.path(stamp if before is None else before.stamp, stamp)
        t, u, first = stamp / 1e9, path.u[path.pieces].copy(), before is None

        def expected() -> Array:
            return expected_outputs(self.stepper, path, t, u, self.x, self.p)

        # Overflow is found below; compiled steps do not warn either.
        with np.errstate(all='ignore'):
            if first:
                self._intake.begin(outputs_at(self.model, t, u, self.x, self.p))
            now = Instant(stamp, t, self._intake.taken(y, expected, first=first), u)
            if before is None:
                self._begin(now)
            else:
                self._step(before, now, path)
            self._intake.note(t, now.y, self.innovation, first=first)
        self._diverged = not math.isfinite(sum(self.x.tolist()) + sum(self.p.tolist()))
        if self._diverged:
            wrong = np.flatnonzero(~np.isfinite(np.concatenate([self.x, self.p])))
            name = self.model.variables[wrong[0]].name if wrong.size else 'the sum of all'
            self._remark_on(
                'reset_non_finite', f'started again at {now.t:g} s, because {name} was not finite'
            )
            self._begin(now)
        self._before, self._due, self._taken = now, True, self._taken + 1
        self._step_time = time.perf_counter() - begin

    def _begin(self, now: Instant) -> None:
        self._set_out()
        self._start(now)

    def _set_out(self) -> None:
        """Put everything where it starts."""
        self.rng = random_generator(self._seed)
        self.x[:], self.p[:] = np.split(self.initial, [self.x.size])
        self.stddev[:] = self.innovation[:] = self.innovation_stddev[:] = math.nan
        self.stddev[self._fixed_parameters] = 0.0
        self.figures.clear()
        self._intake.clear()

    def _forget(self) -> None:
        self._due = self._diverged = self._blind = False
        self._before, self._taken, self._remark, self._step_time = None, 0, '', 0.0
        self._live = None  # steps are chosen anew
        self._set_out()
