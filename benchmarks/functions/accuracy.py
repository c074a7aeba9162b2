"""Errors of compiled elementary functions, beside the values in extended precision."""

from typing import Any, NamedTuple

import numpy as np

from obs_ros import Model, Record, Variable
from obs_ros.core.elementary import ELEMENTARY
from obs_ros.core.typing import Array
from obs_ros.integration.compiled import CompiledKernels
from obs_ros.integration.grid import Grid

# Exponents of ten of the arguments' sizes; of both signs, where the function has such values.
RANGES: dict[str, tuple[float, float]] = {
    'tiny': (-320.0, -10.0), 'common': (-3.0, 1.5), 'large': (1.0, 14.0), 'huge': (14.0, 308.0),
}  # fmt: skip
TWO = ('arctan2', 'power', 'hypot')


class Error(NamedTuple):
    """Worst errors in units in the last place, by range; NaN where no value is finite."""

    name: str
    by_range: dict[str, float]


def errors(points: int, seed: int) -> list[Error]:
    """Return the errors of every function, at random points."""
    rng = np.random.default_rng(seed)
    found = {name: Error(name, {}) for name in ELEMENTARY}
    for kind, (low, high) in RANGES.items():
        a, b = 10.0 ** rng.uniform(low, high, (2, points)) * rng.choice([-1.0, 1.0], (2, points))
        for name, values in compiled(a, b).items():
            found[name].by_range[kind] = ulps(values, true(name, a, b))
    return list(found.values())


def compiled(a: Array, b: Array) -> dict[str, Array]:
    """Return the values (points,) of every function as a model's output computes it."""
    functions = {name: getattr(np, name) for name in ELEMENTARY}

    def output(t: Any, x: Any, u: Any, p: Any) -> Any:
        return [f(*x) if name in TWO else f(x[0]) for name, f in functions.items()]

    model = Model(
        name='functions',
        states=(Variable('a', lower=0.2, upper=1.7), Variable('b', lower=0.2, upper=1.7)),
        outputs=tuple(map(Variable, functions)),
        parameters=(),
        dynamics=lambda t, x, u, p: (0.0, 0.0),
        output=output,
    )
    grid = Grid.of(model, Record([0.0, 1.0], None, np.zeros((2, len(functions)))), np.ones(1))
    _, outputs = CompiledKernels(model).trajectories(grid, np.array([a, b]), np.zeros((0, a.size)))
    return dict(zip(functions, outputs[0], strict=True))


def true(name: str, a: Array, b: Array) -> Any:
    """Return the values in extended precision."""
    arguments = [each.astype(np.longdouble) for each in ((a, b) if name in TWO else (a,))]
    with np.errstate(all='ignore'):
        return getattr(np, name)(*arguments)


def ulps(values: Array, expected: Any) -> float:
    """Return the worst error of finite values in units in the last place."""
    with np.errstate(all='ignore'):
        unit = np.spacing(np.abs(expected.astype(np.float64)))
        error = np.abs((values.astype(np.longdouble) - expected) / unit).astype(np.float64)
    return float(error[np.isfinite(unit)].max(initial=0.0))
