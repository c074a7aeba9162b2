"""Extended high-gain observer of unmeasured flows: Zhang et al. 2020, eq. 11-14."""

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np

from obs_ros.core.interconnected_model import InterconnectedModel
from obs_ros.core.model import Model, Variable
from obs_ros.core.typing import Array
from obs_ros.observers.papers.channels import Channel, each
from obs_ros.observers.papers.flow import (
    FlowObserver,
    FlowSettings,
    away,
    clipped,
    inward,
    observer_model,
)
from obs_ros.observers.settings import setting


@dataclass(frozen=True)
class HighGainSettings(FlowSettings):
    """Settings of the high-gain observer."""

    theta: float = setting(
        2.0, 'gain; large: fast and noisy (the paper takes 80)', '1/s', positive=True, upper=1e6
    )


class HighGainObserver(FlowObserver):
    """Flows as states that are constant but for the correction.

    With e = That - y, for each output:

        That' = f(That) + g(That) Fhat - 2 theta e
        Fhat' = - theta^2 e / g(That)

    The print has theta^2 hA/(rho cp V) (Tp - Tu) where theta^2 / g belongs. g is kept away from
    zero by the model's `least_gain`, with its sign, and Fhat inside the bounds of the flow.
    """

    Settings = HighGainSettings
    fed = 0.0  # share of the actuators' F' = c X' that Fhat' takes over

    def _observer(self) -> Model:
        return high_gain_model(self.model, self.fed, self.settings.step / self.settings.theta)

    def _tuning(self) -> Array:
        return np.array([self.settings.theta])


@functools.lru_cache(maxsize=64)
def high_gain_model(model: InterconnectedModel, fed: float, max_step: float) -> Model:
    """Return the observer's differential equation: theta is its parameter, That its filters."""
    limits = list(zip(model.least_gain, model.flows, strict=True))
    process = each([_process(least, flow) for least, flow in limits])
    flow = each([_flow(least, flow, fed) for least, flow in limits])
    errors = each([_error] * len(limits))
    drift, gain = model.drift, model.gain

    def rates(
        t: Any, F: Any, T: Any, u: Any, y: Any, weight: Any, feed: Any, p: Any, s: Any
    ) -> tuple[Any, ...]:
        e = errors(T, F, F, F, y, weight, s)
        f, g = drift(t, T, u, p), gain(t, T, u, p)
        return flow(T, F, f, g, e, feed, s) + process(T, F, f, g, e, feed, s)

    kind = 'interconnected' if fed else 'high_gain'
    return observer_model(model, kind, len(limits), ('theta',), rates, max_step)


def _error(T: Any, F: Any, f: Any, g: Any, y: Any, weight: Any, s: Any) -> Any:
    return weight * (T - y)


def _process(least: float, flow: Variable) -> Channel:
    lower, upper = flow.lower, flow.upper

    def rate(T: Any, F: Any, f: Any, g: Any, e: Any, feed: Any, s: Any) -> Any:
        return f + away(g, least) * clipped(F, lower, upper) - 2.0 * s[0] * e

    return rate


def _flow(least: float, flow: Variable, fed: float) -> Channel:
    lower, upper = flow.lower, flow.upper

    def rate(T: Any, F: Any, f: Any, g: Any, e: Any, feed: Any, s: Any) -> Any:
        return inward(fed * feed - s[0] * s[0] * e / away(g, least), F, lower, upper)

    return rate
