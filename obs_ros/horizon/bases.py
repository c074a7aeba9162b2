"""The models that a window with process noise may be believed to have.

Process noise and its parameters; those of output error, with a filtered state at the end; or output
error alone. Forecasts decide, see `Forecasts`: those inside the window as long as none that
followed has been judged.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from obs_ros.core.typing import Array
from obs_ros.horizon.disturbance import DisturbedWindow
from obs_ros.horizon.forecasts import Basis, Ends
from obs_ros.inference.assessment.output_error import output_error_covariance
from obs_ros.inference.assessment.skill import forecast_errors
from obs_ros.inference.assessment.uncertainty import AtEnd
from obs_ros.inference.disturbed import Disturbed, disturbed_at
from obs_ros.inference.jumps.hypothesis import Hypothesis
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.window_state import WindowState


@dataclass(frozen=True)
class BasisSettings:
    """Limits in believing output error where process noise is more likely.

    - `gain`, `deviations`: in mean log MSE of the forecasts inside the window, by which its
      parameters must foretell better, and so many standard deviations of that mean besides: of a
      right model both foretell alike.
    """

    gain: float = 0.3
    deviations: float = 2.0


BASIS = BasisSettings()


@dataclass(frozen=True)
class Bases:
    """A posed window, its hypothesis `plain` without process noise, and that with it."""

    posed: WindowState
    plain: Hypothesis
    own: DisturbedWindow

    @property
    def distinct(self) -> bool:
        """Whether there is more than one basis: jumps belong to one hypothesis alone."""
        return not (self.own.hypothesis.problem.events or self.plain.problem.events)

    @cached_property
    def _filtered(self) -> Disturbed:
        """The window at the optimum of output error, its state filtered with the same gains.

        Walks and noise are as much larger as its innovations are.
        """
        window = replace(self.posed, prior=self.own.hypothesis.problem.prior)
        at = disturbed_at(window, self.plain.point, self.own.noise)
        e, S = at.along.innovations, at.along.S
        known = ~np.isnan(e)
        ratio = float(np.sqrt(np.mean(e[known] ** 2 / S[known]))) if known.any() else np.nan
        if not np.isfinite(ratio):
            return at
        return disturbed_at(window, self.plain.point, self.own.noise.scaled(ratio))

    @property
    def ends(self) -> dict[Basis, Ends]:
        """State and parameters at the end, by basis."""
        found = {Basis.PROCESS_NOISE: ends_of(self.own.hypothesis, self.own.end)}
        if self.distinct:
            plain, along = ends_of(self.plain), self._filtered.along
            moved = self._filtered.parameters
            found[Basis.FILTERED] = Ends(
                along.states[self._filtered.last], plain.parameters if moved is None else moved
            )
            found[Basis.OUTPUT_ERROR] = plain
        return found

    def window(self, basis: Basis) -> DisturbedWindow:
        """Return the window by a basis, its deviations as process noise makes them."""
        if basis is Basis.PROCESS_NOISE or not self.distinct:
            return self.own
        at, plain = self._filtered, self.plain
        filtered = replace(
            DisturbedWindow.of(at.window, self.own.found, at),
            covariance=output_error_covariance(plain, at.noise, at.along),
        )
        if basis is Basis.FILTERED:
            return filtered
        off = plain.trajectory[0][at.last] - at.along.states[at.last]
        unknown = np.zeros(len(filtered.end.covariance) - off.size)
        return replace(
            filtered,
            window=replace(self.posed, objective=plain.problem.objective, noise_known=True),
            found=replace(filtered.found, z=plain.point, cost=plain.squares),
            hypothesis=plain,
            end=AtEnd(filtered.end.covariance + np.diag(np.append(off**2, unknown))),
        )

    def by_cross_validation(self, settings: BasisSettings = BASIS) -> Basis:
        """Return the basis whose forecasts inside the window are clearly better."""
        if not self.distinct:
            return Basis.PROCESS_NOISE
        at = self._filtered
        through = PiecewiseProblem(at.window.objective, at.window.prior)
        gained = (
            forecast_errors(self.own.hypothesis).logs - forecast_errors(self.plain, through).logs
        )
        sure = settings.deviations * np.std(gained) / np.sqrt(gained.size)
        better = np.mean(gained) - sure > settings.gain
        return Basis.FILTERED if better else Basis.PROCESS_NOISE


def ends_of(best: Hypothesis, end: AtEnd | None = None) -> Ends:
    """Return state and parameters at the end of a window."""
    objective = best.problem.objective
    last = int(np.flatnonzero(objective.grid.measured)[-1])
    final = best.point[best.final]
    parameters: Array = objective.unknowns.values(final[None])[1][:, 0]
    if end is not None and end.parameters is not None:
        parameters = end.parameters
    return Ends(best.trajectory[0][last], parameters)
