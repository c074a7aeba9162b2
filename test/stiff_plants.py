"""Plants that are stiff, that kink, and that are neither, whose users choose no step."""

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from obs_ros import Model, Record, Variable
from obs_ros.core.estimate import Estimate
from obs_ros.core.typing import Array


def _motor(t: Any, x: Any, u: Any, p: Any) -> Any:
    current, speed = x
    return (u[0] - p[0] * current - p[1] * speed) / 1e-4, (p[1] * current - 1e-4 * speed) / 1e-3


MOTOR = Model(  # electrically in .1 ms, sampled at 10 ms
    name='motor',
    states=(Variable('current', 'A', -50, 50), Variable('speed', 'rad/s', -100, 100)),
    inputs=(Variable('voltage', 'V'),),
    outputs=(Variable('speed', 'rad/s'),),
    parameters=(Variable('R', 'ohm', 0.2, 5.0), Variable('k', 'N m/A', 0.01, 0.2)),
    dynamics=_motor,
    output=lambda t, x, u, p: (x[1],),
)


def van_der_pol(mu: float) -> Model:
    """An oscillator that relaxes, of a damping near mu."""
    return Model(
        name='van_der_pol',
        states=(Variable('x', '1', -3, 3), Variable('rate', '1/s', -2 - 2 * mu, 2 + 2 * mu)),
        outputs=(Variable('x'),),
        parameters=(Variable('mu', '1', mu / 2, mu * 2),),
        dynamics=lambda t, x, u, p: (x[1], p[0] * (1.0 - x[0] ** 2) * x[1] - x[0]),
        output=lambda t, x, u, p: (x[0],),
    )


def _robertson(t: Any, x: Any, u: Any, p: Any) -> Any:
    a, b, c = x
    slow, middle, quick = p[0] * a, 1e4 * b * c, 3e7 * b * b
    return middle - slow, slow - middle - quick, quick


ROBERTSON = Model(
    name='robertson',
    states=(Variable('a', '1', 0, 1.2), Variable('b', '1', 0, 1e-3), Variable('c', '1', 0, 1.2)),
    outputs=(Variable('a'), Variable('c')),
    parameters=(Variable('rate', '1/s', 0.01, 0.2),),
    dynamics=_robertson,
    output=lambda t, x, u, p: (x[0], x[2]),
)


def _flow(valve: Any, head: Any) -> Any:
    return 0.16 * valve * np.copysign(np.sqrt(np.abs(head)), head)


KINKED = Model(  # two tanks whose levels cross, over and over
    name='kinked',
    states=(Variable('h1', 'cm', 0, 100), Variable('h2', 'cm', 0, 100)),
    inputs=(Variable('feed1', 'cm/s'), Variable('feed2', 'cm/s')),
    outputs=(Variable('h1', 'cm'), Variable('h2', 'cm')),
    parameters=(Variable('valve', '1', 0.2, 5.0),),
    dynamics=lambda t, x, u, p: (
        u[0] - _flow(p[0], x[0] - x[1]),
        u[1] + _flow(p[0], x[0] - x[1]),
    ),
    output=lambda t, x, u, p: (x[0], x[1]),
)


def truth(
    model: Model, t: Array, u: Array, x0: Any, p: Any, *, states: bool = False, by: str = 'LSODA'
) -> Array:
    """Outputs (K, r), or states (K, n), by an integrator of scipy at rtol 1e-10, inputs held.

    LSODA takes a tenth of Radau's time, but does not end for Robertson's kinetics; DOP853 is for
    plants that are not stiff.
    """
    x, rows = np.array(x0, dtype=float), []
    for k in range(t.size):
        if k:
            x = solve_ivp(
                lambda s, y, k=k: model.dynamics(s, tuple(y), tuple(u[k - 1]), tuple(p)),
                (t[k - 1], t[k]), x, method=by, rtol=1e-10, atol=1e-13,
            ).y[:, -1]  # fmt: skip
        rows.append(x if states else model.output(t[k], tuple(x), tuple(u[k]), tuple(p)))
    return np.array(rows)


def measured(
    model: Model,
    t: Array,
    u: Array,
    x0: Any,
    p: Any,
    share: float = 0.01,
    seed: int = 1,
    *,
    by: str = 'LSODA',
) -> tuple[Record, dict[str, float]]:
    """A record with noise of a share of the outputs' deviations, and that noise by name."""
    y = truth(model, t, u, x0, p, by=by)
    sd = share * y.std(axis=0)
    noisy = y + sd * np.random.default_rng(seed).standard_normal(y.shape)
    return Record(t, u, noisy), dict(zip((v.name for v in model.outputs), sd.tolist(), strict=True))


def integration_error(
    model: Model, estimate: Estimate, u: Array, noise: Any, *, by: str = 'LSODA'
) -> float:
    """The largest error of an estimate's outputs, in deviations of the noise, beside the truth."""
    t, p = estimate.times, tuple(estimate.parameters.values())
    exact = truth(model, t, u, list(estimate.initial_state.values()), p, by=by)
    rows = zip(t, estimate.states, u, strict=True)
    own = np.array([model.output(s, tuple(x), tuple(v), p) for s, x, v in rows])
    return float(np.abs((own - exact) / np.array(list(noise.values()))).max())
