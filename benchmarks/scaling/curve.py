"""A growth of the cost, as measured."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.metered import Spent

CAUSES: Mapping[str, Callable[[Spent], float]] = {
    'candidate-steps': lambda run: run.steps,
    'kernel calls': lambda run: run.calls,
    's / candidate-step': lambda run: run.kernel_seconds / run.steps,
    's outside kernels': lambda run: run.seconds - run.kernel_seconds,
}


class Curve(NamedTuple):
    """One way to grow: title, x and its name, rows of the table, s per solve, a remark.

    `causes` are the parts of the cost, by name, at every x.
    """

    title: str
    x_name: str
    x: Sequence[float]
    seconds: Sequence[float]
    rows: Sequence[Mapping[str, object]]
    remark: str
    causes: Mapping[str, Sequence[float]] = {}

    @property
    def exponents(self) -> tuple[float, float]:
        """Growth of the cost: exponent over all, and over the upper half."""
        half = len(self.x) // 2
        return exponent(self.x, self.seconds), exponent(self.x[half:], self.seconds[half:])


def exponent(x: Sequence[float], y: Sequence[float]) -> float:
    """Fit y = a x^e; return e."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])
