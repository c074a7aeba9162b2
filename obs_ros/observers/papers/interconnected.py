"""Interconnected observer of a process and its actuators: Zhang et al. 2020, eq. 11, 23 and 26."""

import math
from dataclasses import dataclass

import numpy as np

from obs_ros.observers.papers.high_gain import HighGainObserver, HighGainSettings
from obs_ros.observers.settings import setting


@dataclass(frozen=True)
class InterconnectedSettings(HighGainSettings):
    """Settings of the interconnected observer."""

    l1: float = setting(
        0.0, 'pulls openings to those of the flows; hides faults', '1/s', lower=0.0, upper=1e6
    )
    l2: float = setting(
        0.0, "the same for the openings' rates; hides faults", '1/s2', lower=0.0, upper=1e6
    )


class InterconnectedObserver(HighGainObserver):
    """The high-gain observer, with the rates of the flows from the actuators' model.

        Fhat' = c Xhat' - theta^2 e / g(That)
        Xhat' = the actuators' model - l1 (Xhat - Fhat/c),   Xhat'' likewise with l2

    The chamber pressures are inputs, measured as in section 4.3: eq. 47 estimates them too, with
    gains k3 and k6, from command pressures and a volume that are not printed.

    The print adds Aa/m c u to Fhat', which is not in the derivative of c X. Its gains l1 and l2
    are so small that nothing changes; larger ones pull a faulty actuator's model to the flow, and
    the residual with it. So both are 0 unless set.
    """

    Settings = InterconnectedSettings
    fed = 1.0

    def _correct(self, dt: float) -> None:
        l1, l2 = self.settings.l1, self.settings.l2
        if not (l1 or l2):
            return
        implied = self.flows / np.array(self.model.flow_gain(self.p))
        difference = self.x[self._opening] - implied
        # The first as a lag that is exact for any dt: it can overshoot with none.
        self.x[self._opening] -= -math.expm1(-l1 * dt) * difference
        if rates := self.model.rate_index:
            self.x[list(rates)] -= dt * l2 * difference
