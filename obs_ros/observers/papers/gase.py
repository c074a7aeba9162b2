"""Genetic adaptive state estimator: Gremling & Passino 2000.

At every output k a population of parameters theta, written in decimal digits, is bred anew g_t
times. Each candidate goes through the last W + 1 samples with forward Euler steps (eqs. 3, 18, 23),
the measured states replaced by their measurement before each step; its cost is the sum of the
squared output errors (eqs. 4-5). The best rho D survive, the others descend from the best D.

In the paper the state estimate takes one step with the best candidate's parameters, and each step
runs under the input u(k-1) at its begin (mode `paper`); one that runs on between samples then comes
half a sample late. In mode `window_end` the inputs are at their mean over each step, which is
u(k-1) where they are held, and the state is where the best candidate ends in the window, so that
errors of older parameters are not propagated. Window errors leave directions of theta all but free
at 50 samples: more search does not help there, longer windows do.
"""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from obs_ros.core.model import Model, names
from obs_ros.core.typing import Array, IntArray
from obs_ros.integration.path import Path, Stretch, lanes
from obs_ros.integration.series_parallel import measured_states, series_parallel_for
from obs_ros.observers.output_intake import Instant
from obs_ros.observers.papers.euler import mean_inputs
from obs_ros.observers.recursive import RecursiveObserver
from obs_ros.observers.settings import Settings, setting
from obs_ros.optimization.decimal_coding import Base10
from obs_ros.optimization.ga import check_breeding
from obs_ros.optimization.trait_breeding import offspring


@dataclass(frozen=True)
class GaseSettings(Settings):
    """The paper's constants of section 4.2."""

    most_steps: ClassVar[int] = 10_000_000  # of all candidates, a sample: tenths of a second
    mode: str = setting(
        'window_end',
        "the state is where the best candidate's window ends, or as in the paper one step on",
        choices=('window_end', 'paper'),
    )
    population: int = setting(200, 'candidates N', lower=4, upper=10_000)
    parents: int = setting(70, 'how many of the best may be parents, D', lower=2, upper=10_000)
    elite: int = setting(10, 'how many of the best survive, rho D', lower=1, upper=10_000)
    mutation: float = setting(0.2, 'probability p_m that a digit mutates', upper=1.0, positive=True)
    window: int = setting(50, 'samples W of the window, besides the newest', lower=1, upper=10_000)
    generations: int = setting(10, 'generations g_t for each sample', lower=1, upper=1000)
    digits: int = setting(5, 'digits of each parameter, at least', lower=2, upper=15)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_breeding(self.population, self.parents, self.elite, self.mutation)
        steps = self.population * self.window * self.generations
        if steps > self.most_steps:
            raise ValueError(
                f'population, window or generations must be smaller: their product {steps} is the '
                f'steps for each sample, at most {self.most_steps}'
            )


class GeneticAdaptiveStateEstimator(RecursiveObserver):
    """Parameters within their bounds, and states, by a base-10 genetic algorithm on a window.

    Figures: `cost`, the sum of the best candidate's squared output errors over the window, in units
    of the noise where that is given; `generation`, how many were bred so far.

    Raises ValueError for a model without parameters to estimate, with infinite bounds on one, or
    with an output that is none of its states.
    """

    Settings: ClassVar[type[Settings]] = GaseSettings

    def __init__(self, model: Model | str, **arguments: Any) -> None:
        super().__init__(model, **arguments)
        n = len(self.model.states)
        self._estimated: IntArray = self.unknowns.index[self.unknowns.index >= n]
        if not self._estimated.size:
            raise ValueError(f'{type(self).__name__} needs a parameter to estimate')
        self._rows = compact(self._estimated - n)
        lower, upper = self.lower[self._estimated], self.upper[self._estimated]
        for i, low, high in zip(self._estimated, lower, upper, strict=True):
            if not np.isfinite([low, high]).all():
                name = self.model.variables[i].name
                raise ValueError(f'{name} needs finite bounds, not {low} to {high}')
        self._limits = self.lower[:n], self.upper[:n]
        self._coding = Base10.of(lower, upper, self.settings.digits)
        outputs = names(self.model.outputs)
        weight = np.array([1.0 / self.noise.get(name, 1.0) for name in outputs])
        self._window = _Window(self.model, self.settings.window + 2, weight)

    @classmethod
    def suits(cls, model: Model) -> None:
        measured_states(model)

    def _start(self, now: Instant) -> None:
        self._steps = series_parallel_for(self.model, self.backend)
        draws = self.rng.random((self.settings.population, self._estimated.size))
        self._genes = self._coding.first_population(draws)
        self._values = self._coding.decode(self._genes)
        self._generation = 0
        # Arrays for parameters by their width: of all candidates, or of the children.
        count = self.settings.population
        self._lanes = {
            width: np.repeat(self.p[:, None], width, axis=1)
            for width in (lanes(count), lanes(count - self.settings.elite))
        }
        self.innovation[:] = now.y - self.x[self._steps.measured]
        self._window.begin(now.y, self.x)

    def _step(self, before: Instant, now: Instant, path: Path) -> None:
        window, measured = self._window, self._steps.measured
        whole = self.settings.mode == 'window_end'
        u = mean_inputs(path) if whole else path.u[0]
        window.append(before.t, (now.stamp - before.stamp) / 1e9, u, now.y)
        theta, cost = self._evolve()
        self.p[self._rows] = theta
        best = np.repeat(self.p[:, None], lanes(1), axis=1)
        stretch = window.whole(measured) if whole else window.newest(measured)
        self.x[:] = self._pursue(*stretch, best)[1][:, 0]
        self.innovation[:] = now.y - self.x[measured]
        window.keep(self.x)
        self.figures.update(cost=cost, generation=float(self._generation))

    def _evolve(self) -> tuple[Array, float]:
        """Breed g_t times; return the parameters and the cost of the best candidate meanwhile."""
        elite, stretch = self.settings.elite, self._window.whole(self._steps.measured)
        costs = self._costs(self._values, *stretch)
        for _ in range(self.settings.generations - 1):
            order = costs.argsort(kind='stable')
            self._breed(order)
            # The elite come first now, best first; what they cost is known.
            costs[:elite] = costs[order[:elite]]
            costs[elite:] = self._costs(self._values[elite:], *stretch)
        order = costs.argsort(kind='stable')
        found = self._values[order[0]], float(costs[order[0]])
        self._breed(order)
        return found

    def _breed(self, order: IntArray) -> None:
        s = self.settings
        self._genes, self._values = offspring(
            self._genes, order, s.parents, s.elite, s.mutation, self._coding, self.rng
        )
        self._generation += 1

    def _costs(self, values: Array, stretch: Stretch, x0: Array) -> Array:
        """Return costs (B,) of candidates (B, d) from x0 (n,); +inf who diverges."""
        count = len(values)
        p = self._lanes[lanes(count)]
        p[self._rows, :count] = values.T
        squares = self._pursue(stretch, x0, p)[0][:count]
        return np.where(np.isfinite(squares), squares, np.inf)

    def _pursue(self, stretch: Stretch, x0: Array, p: Array) -> tuple[Array, Array]:
        return self._steps.pursue(stretch, *self._limits, x0, p)


class _Window:
    """The last samples: outputs and estimated states at each, and what happened between them."""

    def __init__(self, model: Model, nodes: int, weight: Array) -> None:
        r, m, n = len(model.outputs), len(model.inputs), len(model.states)
        self._filled = 0
        self._weight = weight
        # The newest come last, so that the rows in use lie together.
        self._t, self._dt, self._u = (
            np.zeros(nodes - 1),
            np.zeros(nodes - 1),
            np.zeros((nodes - 1, m)),
        )
        self._y, self._x = np.zeros((nodes, r)), np.zeros((nodes, n))
        self._known = np.zeros((nodes, r), dtype=np.bool_)

    def begin(self, y: Array, x: Array) -> None:
        """Start with one sample, its outputs and estimated states."""
        self._filled = 1
        self._measure(y)
        self.keep(x)

    def append(self, t: float, dt: float, u: Array, y: Array) -> None:
        """Take the outputs at a new sample and the interval before it, and drop the oldest."""
        for rows in (self._t, self._dt, self._u, self._y, self._known, self._x):
            rows[:-1] = rows[1:]
        self._t[-1], self._dt[-1], self._u[-1] = t, dt, u
        self._measure(y)
        self._filled = min(self._filled + 1, len(self._y))

    def keep(self, x: Array) -> None:
        """Keep the states (n,) estimated at the newest sample."""
        self._x[-1] = x

    def whole(self, measured: IntArray) -> tuple[Stretch, Array]:
        """Return the whole window and the states (n,) at its begin."""
        return self._last(self._filled, measured)

    def newest(self, measured: IntArray) -> tuple[Stretch, Array]:
        """Return the newest interval and the states (n,) at its begin."""
        return self._last(2, measured)

    def _last(self, nodes: int, measured: IntArray) -> tuple[Stretch, Array]:
        x0, y, known = self._x[-nodes].copy(), self._y[-nodes:], self._known[-nodes:]
        x0[measured[known[0]]] = y[0, known[0]]
        steps = slice(len(self._dt) - nodes + 1, None)
        return Stretch(self._t[steps], self._dt[steps], self._u[steps], y, known, self._weight), x0

    def _measure(self, y: Array) -> None:
        self._known[-1] = np.isfinite(y)
        self._y[-1] = np.where(self._known[-1], y, 0.0)


def compact(rows: IntArray) -> IntArray | slice:
    """Return rising rows as a slice where none is left out: that takes a third of the time."""
    first, last = int(rows[0]), int(rows[-1])
    return slice(first, last + 1) if rows.size == last + 1 - first else rows
