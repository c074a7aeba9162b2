"""Plants and windows that several tests share."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from obs_ros import Model, Record, Variable
from obs_ros.core.typing import Array
from obs_ros.inference.objective import Objective
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.models.three_tank import THREE_TANK

NAN = np.nan
STIFFNESS = 4.0


def damping(gain: float) -> Any:
    """A helper whose constant is in its closure."""

    def force(v: Any) -> Any:
        return -gain * v * np.sqrt(1.0 + v * v)

    return force


_force = damping(0.3)


def _spring(x: Any) -> Any:
    return -STIFFNESS * x


def oscillator_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    """Time dependence, a global constant, a helper and a helper with a closure."""
    position, velocity = x
    return velocity, p[0] * _spring(position) + _force(velocity) + u[0] + p[1] * np.cos(3.0 * t)


def oscillator_output(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any]:
    return x[0] + 0.1 * u[0], x[1] * p[0] + 0.01 * t


OSCILLATOR = Model(
    name='oscillator',
    states=(Variable('position', lower=-3.0, upper=3.0), Variable('velocity', 'm/s', -3.0, 3.0)),
    inputs=(Variable('force'),),
    outputs=(Variable('y1'), Variable('y2')),
    parameters=(
        Variable('stiffness', lower=0.2, upper=2.0),
        Variable('push', lower=0.0, upper=2.0),
    ),
    dynamics=oscillator_dynamics,
    output=oscillator_output,
    max_step=0.05,
)


# x' = x^2: neither inputs nor parameters, and infinite at t = 1 / x(0).
BLOW_UP = Model(
    name='blow_up',
    states=(Variable('x', lower=-1.0, upper=4.0),),
    outputs=(Variable('y'),),
    dynamics=lambda t, x, u, p: (x[0] * x[0],),
    output=lambda t, x, u, p: (x[0],),
    max_step=0.01,
)

# x' = x^3: infinite at t = 1 / (2 x(0)^2), beyond which there is no solution.
NO_FUTURE = replace(
    BLOW_UP,
    name='no_future',
    integrator='rk4',
    dynamics=lambda t, x, u, p: (x[0] * x[0] * x[0],),
)

# x' = d - u, y = x + g u: a vessel with a load d and, where g is not 0, an input seen at once.
VESSEL = Model(
    name='vessel',
    states=(Variable('x'),),
    inputs=(Variable('u'),),
    outputs=(Variable('y'),),
    parameters=(Variable('d'), Variable('g')),
    dynamics=lambda t, x, u, p: (p[0] - u[0],),
    output=lambda t, x, u, p: (x[0] + p[1] * u[0],),
)


def with_interpolation(model: Model, interpolation: Any) -> Model:
    """The same plant with other inputs."""
    return replace(model, inputs=[replace(v, interpolation=interpolation) for v in model.inputs])


def exact(
    model: Model, t: Array, u: Any, x0: Sequence[float], p: Sequence[float]
) -> tuple[Array, Array]:
    """States (K, n) and outputs (K, r) by scipy, stopping at every node; u(k, s) are the inputs s
    seconds after node k."""
    states = [np.asarray(x0, dtype=np.float64)]
    for k in range(t.size - 1):
        solution = solve_ivp(
            lambda s, x, k=k: model.dynamics(s, tuple(x), u(k, s - t[k]), tuple(p)),
            (t[k], t[k + 1]),
            states[-1],
            rtol=1e-10,
            atol=1e-12,
        )
        states.append(solution.y[:, -1])
    outputs = [model.output(t[k], tuple(x), u(k, 0.0), tuple(p)) for k, x in enumerate(states)]
    return np.array(states), np.array(outputs)


def tank_outputs(t: Array, x0: Sequence[float], p: Sequence[float], step: float = 1.0) -> Array:
    """Levels h1, h2 (K, 2) of three tanks fed with 30 cm3/s, by this file's own RK4.

    x0 (3,) and p (3,) may have candidates behind: (3, B) gives (K, 2, B).
    """

    def rates(h: Array) -> Array:
        def flow(opening: Array, head: Array) -> Array:
            area = 0.6 * 0.6 * opening
            return np.asarray(area * np.sign(head) * np.sqrt(2 * 981.0 * np.abs(head)))

        q13, q32 = flow(p[0], h[0] - h[2]), flow(p[2], h[2] - h[1])
        q20 = flow(p[1], h[1])
        return np.stack([30.0 - q13, 30.0 + q32 - q20, q13 - q32]) / 100.0

    h = np.asarray(x0, dtype=np.float64)
    p = np.asarray(p, dtype=np.float64)
    levels = [h]
    for interval in np.diff(t):
        count = max(1, int(np.ceil(interval / step - 1e-9)))
        for _ in range(count):
            dt = interval / count
            k1 = rates(h)
            k2 = rates(h + dt / 2 * k1)
            k3 = rates(h + dt / 2 * k2)
            k4 = rates(h + dt * k3)
            h = h + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        levels.append(h)
    return np.stack(levels)[:, :2]


def tank_record(
    x0: Sequence[float] = (50.0, 40.0, 45.0),
    p: Sequence[float] = (0.6, 0.5, 0.7),
    *,
    nodes: int = 301,
    interval: float = 1.0,
    start: float = 0.0,
    sigma: float = 0.01,
    seed: int = 0,
) -> Record:
    """A window of three tanks with white noise of standard deviation sigma (cm)."""
    t = start + interval * np.arange(nodes)
    noise = np.random.default_rng(seed).standard_normal((nodes, 2))
    return Record(t, np.full((nodes, 2), 30.0), tank_outputs(t - start, x0, p) + sigma * noise)


COARSE_TANKS = replace(THREE_TANK, max_step=5.0)


# x' = gain u + drift, y = x: with its input held, linear in x(0), gain and drift, without error of
# integration, and even a jump between two samples is only a change of mean.
INTEGRATOR = Model(
    name='integrator',
    states=(Variable('x', lower=-10.0, upper=10.0),),
    inputs=(Variable('u'),),
    outputs=(Variable('y'),),
    parameters=(
        Variable('gain', lower=0.0, upper=2.0, nominal=1.0),
        Variable('drift', lower=-1.0, upper=1.0, nominal=0.0),
    ),
    dynamics=lambda t, x, u, p: (p[0] * u[0] + p[1],),
    output=lambda t, x, u, p: (x[0],),
)


def integrator_design(t: Array, u: Array) -> Array:
    """Columns (K, 3) of what x(0), gain and drift, in their units, do to y (K,)."""
    fed = np.concatenate([[0.0], np.cumsum(u[:-1] * np.diff(t))])
    return np.column_stack([np.ones(t.size), fed, t - t[0]])


LAG = Model(
    name='lag',
    states=(Variable('x', lower=-10.0, upper=10.0),),
    inputs=(Variable('u'),),
    outputs=(Variable('y'),),
    parameters=(
        Variable('k', lower=0.2, upper=5.0, nominal=1.0),
        Variable('tau', 's', lower=1.0, upper=20.0, nominal=5.0),
    ),
    dynamics=lambda t, x, u, p: ((p[0] * u[0] - x[0]) / p[1],),
    output=lambda t, x, u, p: (x[0],),
    max_step=0.1,
)


def lag_outputs(t: Array, u: Array, x0: float, p: Array) -> Array:
    """y (K,) of LAG in closed form; p (K, 2) is (k, tau) from each node to the next."""
    y = np.empty(t.size)
    y[0] = x0
    for i, interval in enumerate(np.diff(t)):
        end = p[i, 0] * u[i]
        y[i + 1] = end + (y[i] - end) * np.exp(-interval / p[i, 1])
    return y


def square_wave(t: Array, half: float = 3.0) -> Array:
    """1 and -1 by turns (K,), each for `half` s."""
    return np.where((t + 1e-9) // half % 2 == 0, 1.0, -1.0)


def window_of(
    model: Model, record: Record, sigma: float, backend: Any = 'numpy', **settings: Any
) -> Objective:
    """The least squares of a record, with every output's noise `sigma`."""
    grid = Grid.of(model, record, np.full(len(model.outputs), sigma))
    return Objective(kernels_for(model, backend), grid, Unknowns.of(model, **settings))


def observer_form_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, Any, Any]:
    """x' = [-a | I; 0] x + b u."""
    x1, x2, x3 = x
    a2, a1, a0, b2, b1, b0 = p
    return x2 - a2 * x1 + b2 * u[0], x3 - a1 * x1 + b1 * u[0], -a0 * x1 + b0 * u[0]


def observer_form(**ranges: tuple[float, float]) -> Model:
    """The third-order plant of Gremling & Passino 2000 in its minimum-phase ranges, or others."""
    usual = {
        'a2': (1.8, 2.3), 'a1': (1.8, 2.3), 'a0': (0.8, 1.2),
        'b2': (0.8, 1.2), 'b1': (0.7, 1.1), 'b0': (0.6, 1.1),
    }  # fmt: skip
    return Model(
        name='observer_form',
        states=tuple(Variable(n, '1', -50.0, 50.0, nominal=0.0) for n in ('x1', 'x2', 'x3')),
        inputs=(Variable('u', interpolation='linear'),),
        outputs=(Variable('y'),),
        parameters=tuple(Variable(n, '1', *r) for n, r in {**usual, **ranges}.items()),
        dynamics=observer_form_dynamics,
        output=lambda t, x, u, p: (x[0],),
        max_step=0.01,
    )


def rich_input(t: Any) -> Any:
    """The input of Gremling & Passino 2000, section 4.1."""
    return (
        1.5 * np.sin(3.2 * t) + 3.9 * np.cos(1.9 * t) - 2.6 * np.sin(0.7 * t)
        - 2.1 * np.cos(2.5 * t)
    )  # fmt: skip


def trajectory(model: Model, t: Array, u: Any, x0: Sequence[float], p: Sequence[float]) -> Array:
    """States (K, n) by this file's own RK4, one step an interval; u(t) are the inputs at any t."""

    def rates(s: float, x: Array) -> Array:
        return np.array(model.dynamics(s, tuple(x), u(s), tuple(p)))

    x = np.asarray(x0, dtype=np.float64)
    states = [x]
    for k in range(t.size - 1):
        h = t[k + 1] - t[k]
        k1 = rates(t[k], x)
        k2 = rates(t[k] + h / 2, x + h / 2 * k1)
        k3 = rates(t[k] + h / 2, x + h / 2 * k2)
        k4 = rates(t[k] + h, x + h * k3)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        states.append(x)
    return np.array(states)
