"""Adaptive Luenberger observer (Ioannou & Sun 1996; Gremling & Passino 2000, eqs. 14-16)."""

from dataclasses import dataclass
from typing import Any, ClassVar

from obs_ros.core.model import Model
from obs_ros.observers import settings as table
from obs_ros.observers.output_intake import Instant
from obs_ros.observers.papers.observer_form import (
    ObserverFormObserver,
    ObserverFormSettings,
    regression_error,
)
from obs_ros.observers.settings import setting


@dataclass(frozen=True)
class AdaptiveLuenbergerSettings(ObserverFormSettings):
    """The gradient law's, besides."""

    alpha: float = setting(1.5, 'adaptation gain, Gamma = alpha I', '1/s', positive=True, upper=1e6)
    normalised: bool = setting(
        True, "m^2 = 1 + phi' phi, which bounds the speed of adaptation; false: m^2 = 1"
    )


class AdaptiveLuenbergerObserver(ObserverFormObserver):
    """Lets the parameters follow the gradient of the squared regression error (eq. 16).

    theta' = Gamma eps phi,   eps = (z - theta' phi) / m^2.

    For plants in observer form of order n, with one input and one output, see `observer_form`. It
    has no standard deviations.
    """

    Settings: ClassVar[type[table.Settings]] = AdaptiveLuenbergerSettings

    def __init__(self, model: Model | str, **arguments: Any) -> None:
        super().__init__(model, **arguments)
        self._gain[:] = self.settings.alpha * self._free
        self._normalised = self.settings.normalised

    def _adapt(self, now: Instant, interval: float) -> None:
        error, norm = regression_error(self._s, float(now.y[0]), self._filter)
        self.figures['equation_error'] = error
        self.figures['normalisation'] = norm
