"""Candidates to integrate, and the judgement of their steps: what a choice of steps goes by."""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.integration.grid import TIGHTER

ORDERS = {'rk4': 4, 'euler': 1, 'rosenbrock': 3}


@dataclass(frozen=True)
class StepSettings:
    """Limits in choosing method and steps.

    - `aimed`: integration error in standard deviations of the noise; a tenth adds half a percent
      to what noise leaves;
    - `together`: root of the sum of squared errors of all outputs of a window that counts as much
      as one error `aimed` at: no unknown can be moved by more of its deviations than that;
    - `tolerated`: error of an answer above which it is found anew with finer steps; by three tenths
      of the noise an estimate is hardly moved;
    - `share`: of its distance from the measurements, root mean square, by which a candidate of the
      search may err: its costs, which are ranked, are then right within a third or so;
    - `reference`: the same of the first candidate, at any output: near the measurements it is held
      to `aimed`, and a guess that is far from them is not worth more;
    - `most`: share of these candidates of which that is asked; in the corners of a box a plant may
      well do what it never does;
    - `cheaper`: how many times less another method must cost than RK4, whose kernels are there
      already and whose costs are smooth;
    - `steps`: of one candidate through one window, at most; steps that the model itself asks for by
      its `max_step` come on top;
    - `rounds`: in which steps are spread anew; each needs about six rollouts of a few candidates;
    - `patience`: rounds in a row that bring errors down by less than half, after which they are
      taken for what no steps can lower;
    - `natural`: the same for candidates that diverge all along, where no mode dies out: they do so
      by nature;
    - `alone`: the same where the first candidate errs alone: in chaos errors are as large as its
      motion whatever the steps, which tells nothing of where a search ends;
    - `attempts`: times that an answer is found anew in finer steps;
    - `growth`: by which steps in an interval change in one round;
    - `safety`: share of the error allowed at which the steps aim;
    - `loosest`, `tightest`: tolerances of candidates that take steps of their own; by the last
      rounding counts as much;
    - `smooth`: tolerance of the second search where noise does not explain what the first found: so
      fine, costs are smooth on the scale of the noise where a plant relaxes, and jumps move;
    - `ahead`: times as many steps as most of these candidates that any may take, beside `fewest`
      and not beyond `own`, and ten for each fewest one: what switches all the time ends there.
    """

    aimed: float = 0.1
    together: float = 0.5
    tolerated: float = 0.3
    share: float = 0.2
    reference: float = 0.02
    most: float = 0.75
    cheaper: float = 2.0
    steps: int = 100_000
    rounds: int = 12
    patience: int = 4
    natural: int = 3
    alone: int = 1
    attempts: int = 2
    growth: float = 8.0
    safety: float = 0.5
    loosest: float = 1e-4
    smooth: float = 1e-6
    tightest: float = 1e-10
    ahead: int = 5
    fewest: int = 1000
    own: int = 5_000


STEPPING = StepSettings()
LARGEST = 1e6  # times what is allowed: how much more it is then tells nothing of the steps


class Verdict(NamedTuple):
    """Steps judged: the first candidate's `error` in deviations of the noise, and `excess` (B,).

    Excess is a candidate's error over what it is allowed; infinite where it diverges. `largest` is
    the error, root mean square, of any candidate, in deviations of the noise.
    """

    error: float
    excess: Array
    largest: float = np.inf

    def worst(self, most: float = STEPPING.most) -> float:
        """Return the excess of the first candidate, or that within which `most` others stay."""
        others = common(self.excess[1:], most) if self.excess.size > 1 else 0.0
        return float(max(self.excess[0], others))

    def without(self, exempt: BoolArray | None) -> 'Verdict':
        """Return the verdict in which candidates `exempt` (B,) count for nothing."""
        if exempt is None:
            return self
        return self._replace(excess=np.where(exempt, 0.0, self.excess))


class Trial(Protocol):
    """Candidates, the first of them a reference, to integrate by any method and steps (N,)."""

    def judge(self, method: str, steps: IntArray) -> Verdict:
        """Return how far the candidates are off with these steps."""

    def takes_own(self, method: str) -> bool:
        """Whether candidates take steps of their own by a method."""

    def judge_own(self, method: str, tolerance: float) -> tuple[Verdict, IntArray]:
        """Return how far they are off by steps of their own, and their steps (N, B)."""

    def decays(self) -> bool:
        """Whether any candidate has a mode that dies out within an interval, as stiff plants do."""

    def shares(self, method: str, steps: IntArray, verdict: Verdict) -> Array:
        """Return the share (N,) of each interval in the worst excess; their sum is about that."""


class Choice(NamedTuple):
    """The method, its steps (N,), and the reference's integration error in deviations of noise."""

    method: str
    steps: IntArray
    error: float
    worst: float  # excess of most candidates: up to 1 the steps suffice
    largest: float = np.inf  # error of any candidate
    tolerance: float = 0.0  # of candidates' own steps; `steps` are the reference's then
    budget: int = 0  # of steps of each of them

    @property
    def fine(self) -> bool:
        """Whether errors are within what is allowed."""
        return self.worst <= 1.0


def doubling_error(difference: Array, method: str) -> Array:
    """Return the error of results, by their difference from those of twice as many steps."""
    return np.asarray(np.abs(difference) / (1.0 - 0.5 ** ORDERS[method]))


def own_error(difference: Array) -> Array:
    """Return the error of results, by their difference from those of a tolerance `TIGHTER`.

    Errors of order 3 fall as the tolerance of local errors, whose order is 4, to the power of 3/4.
    """
    return np.asarray(np.abs(difference) / (1.0 - TIGHTER**0.75))


def counted_together(worst: float, together: float, settings: StepSettings = STEPPING) -> float:
    """Return what errors in deviations of the noise count for: the `worst`, or more of many alike.

    An estimate moves by the projection of all of them on its sensitivities; `together`, the root of
    the sum of their squares, is its most, in deviations of an unknown. An infinite one has
    overflown, and tells nothing.
    """
    alike = settings.aimed / settings.together * together
    return max(worst, alike) if alike < np.inf else worst


def common(values: Array, most: float) -> Array:
    """Return along the last axis what a share `most` of the values does not exceed."""
    if not values.shape[-1]:
        return np.zeros(values.shape[:-1])
    place = int(np.ceil(most * values.shape[-1])) - 1
    return np.asarray(np.partition(values, place, axis=-1)[..., place])
