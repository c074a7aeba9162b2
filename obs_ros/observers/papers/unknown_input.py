"""Unknown-input observer of flows by filtered inversion: the rival in Zhang et al. 2020."""

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np

from obs_ros.core.interconnected_model import InterconnectedModel
from obs_ros.core.model import Model, Variable
from obs_ros.core.typing import Array
from obs_ros.observers.output_intake import Instant
from obs_ros.observers.papers.channels import Channel, each
from obs_ros.observers.papers.flow import (
    FlowObserver,
    FlowRates,
    FlowSettings,
    away,
    inward,
    observer_model,
)
from obs_ros.observers.settings import setting


@dataclass(frozen=True)
class UnknownInputSettings(FlowSettings):
    """Settings of the unknown-input observer."""

    tau: tuple[float, ...] = setting(
        (0.5,), 'time constant of both filters: one for all flows, or one for each', 's',
        lower=1e-6, upper=1e6,
    )  # fmt: skip


class UnknownInputObserver(FlowObserver):
    """Solves the process for the flow, with a filtered output and its derivative.

        Tf' = (y - Tf)/tau,   Fhat' = ([(y - Tf)/tau - f(Tf)] / g(Tf) - Fhat)/tau

    Each flow has filters of its own, of all outputs with one tau: then steady flows come out right
    however the outputs move. The process states reported are the outputs as they were measured
    last. Raises ValueError for a tau that is not positive, or a wrong number of them.
    """

    Settings = UnknownInputSettings

    def _observer(self) -> Model:
        return inversion_model(self.model, self.settings.step * float(self._tuning().min()))

    def _tuning(self) -> Array:
        count, tau = len(self.model.flows), self.settings.tau
        if len(tau) not in (1, count) or not min(tau) > 0.0:
            raise ValueError(f'tau must be 1 or {count} positive times in s, not {tau}')
        return np.broadcast_to(np.array(tau), count)

    def _read(self, now: Instant) -> None:
        self.x[: self._count] = np.where(np.isnan(now.y), self.x[: self._count], now.y)


@functools.lru_cache(maxsize=64)
def inversion_model(model: InterconnectedModel, max_step: float) -> Model:
    """Return the observer's differential equation; its parameters are the tau."""
    r = len(model.flows)
    banks = [
        _bank(model, i, least, flow)
        for i, (least, flow) in enumerate(zip(model.least_gain, model.flows, strict=True))
    ]
    all_banks = _joined(banks)
    tuning = tuple(f'tau_{flow.name}' for flow in model.flows)
    return observer_model(model, 'unknown_input', r * r, tuning, all_banks, max_step)


def _bank(model: InterconnectedModel, i: int, least: float, flow: Variable) -> FlowRates:
    """Return the rates of flow i and of its filters."""
    r, drift, gain = len(model.flows), model.drift, model.gain
    begin, end = r * i, r * (i + 1)
    lower, upper = flow.lower, flow.upper
    follow = each([_lag(i)] * r)

    def rates(
        t: Any, F: Any, filters: Any, u: Any, y: Any, weight: Any, feed: Any, p: Any, s: Any
    ) -> tuple[Any, ...]:
        T = filters[begin:end]
        slope = follow(T, T, T, T, y, weight, s)
        raw = (slope[i] - drift(t, T, u, p)[i]) / away(gain(t, T, u, p)[i], least)
        # Where nothing is measured Fhat stays: Tf at rest would pass for a flow.
        return (inward(weight[i] * (raw - F[i]) / s[i], F[i], lower, upper),) + slope  # noqa: RUF005

    return rates


def _joined(banks: list[FlowRates]) -> FlowRates:
    """Return the rates of all flows, then of all filters."""
    bank, i = banks[-1], len(banks) - 1
    if not i:
        return bank
    before = _joined(banks[:-1])

    def rates(
        t: Any, F: Any, filters: Any, u: Any, y: Any, weight: Any, feed: Any, p: Any, s: Any
    ) -> tuple[Any, ...]:
        first = before(t, F, filters, u, y, weight, feed, p, s)
        last = bank(t, F, filters, u, y, weight, feed, p, s)
        return first[:i] + last[:1] + first[i:] + last[1:]

    return rates


def _lag(i: int) -> Channel:
    return lambda T, F, f, g, y, weight, s: weight * (y - T) / s[i]
