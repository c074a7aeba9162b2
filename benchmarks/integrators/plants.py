"""Stiff plants and others, as their users would write them: no step is given."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from obs_ros import Model, Variable
from obs_ros.core.typing import Array


@dataclass(frozen=True)
class Plant:
    """Windows of one plant.

    `model` is what its users write, `mild` the same plant with its fast time constants like the
    others: it has as many unknowns, samples and outputs. `t` (K,) are the samples in s; `inputs`
    draws u (K, m); `start` draws the initial state (n,) of parameters p, None: anywhere in its box.
    """

    name: str
    model: Model
    mild: Model
    t: Array
    inputs: Callable[[np.random.Generator, Array], Array] = lambda rng, t: np.empty((t.size, 0))
    start: Callable[[np.random.Generator, Array], Array] | None = None


def stairs(*limits: tuple[float, float], leaps: int = 10) -> Callable[..., Array]:
    """Inputs that leap so many times in a window, each to somewhere between its limits."""

    def inputs(rng: np.random.Generator, t: Array) -> Array:
        at = np.sort(rng.integers(1, t.size, leaps))
        rows = np.searchsorted(at, np.arange(t.size), side='right')
        low, high = np.array(limits).T
        return np.asarray(rng.uniform(low, high, (leaps + 1, len(limits)))[rows])

    return inputs


def first(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Measure the first state."""
    return (x[0],)


def both(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Measure the first two states."""
    return x[0], x[1]


def motor(electrical: float) -> Model:
    """A DC motor with an electrical time constant L/R, in s, at 1 ohm."""
    inductance, inertia = electrical, 1e-3

    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        current, speed = x
        resistance, torque, friction = p
        return (
            (u[0] - resistance * current - torque * speed) / inductance,
            (torque * current - friction * speed) / inertia,
        )

    return Model(
        name='motor',
        states=(Variable('current', 'A', -30, 30), Variable('speed', 'rad/s', -200, 200)),
        inputs=(Variable('voltage', 'V'),),
        outputs=(Variable('current', 'A'), Variable('speed', 'rad/s')),
        parameters=(
            Variable('resistance', 'ohm', 0.3, 3.0),
            Variable('torque', 'N m/A', 0.02, 0.2),
            Variable('friction', 'N m s', 1e-4, 1e-2),
        ),
        dynamics=dynamics,
        output=both,
    )


def van_der_pol(mu: float) -> Model:
    """An oscillator that relaxes, of a damping near mu."""

    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        return x[1], p[0] * (1.0 - x[0] ** 2) * x[1] - x[0]

    return Model(
        name='van_der_pol',
        states=(Variable('x', '1', -3, 3), Variable('rate', '1/s', -2 - 2 * mu, 2 + 2 * mu)),
        outputs=(Variable('x', '1'),),
        parameters=(Variable('mu', '1', mu / 3, mu * 3, scale='log'),),
        dynamics=dynamics,
        output=first,
    )


def on_the_cycle(rng: np.random.Generator, p: Array) -> Array:
    """Draw a state of van der Pol's oscillator on the slow branch of its cycle."""
    x = rng.uniform(1.2, 2.0) * rng.choice([-1.0, 1.0])
    return np.array([x, -x / (p[0] * (x * x - 1.0)) if p[0] > 5.0 else rng.uniform(-1.0, 1.0)])


def robertson(fast: float) -> Model:
    """Robertson's reaction of three species, `fast` the rate 3e7 of the second with itself."""

    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        a, b, c = x
        k1, k2, k3 = p
        slow, middle, quick = k1 * a, k3 * b * c, k2 * b * b
        return middle - slow, slow - middle - quick, quick

    most_b = 4.0 * np.sqrt(0.2 / fast)
    return Model(
        name='robertson',
        states=(
            Variable('a', 'mol/l', 0.0, 1.2),
            Variable('b', 'mol/l', 0.0, most_b),
            Variable('c', 'mol/l', 0.0, 1.2),
        ),
        outputs=(Variable('a', 'mol/l'), Variable('c', 'mol/l')),
        parameters=(
            Variable('k1', '1/s', 0.01, 0.2, scale='log'),
            Variable('k2', 'l/mol/s', fast / 5.0, fast * 5.0, scale='log'),
            Variable('k3', 'l/mol/s', 1e3 * (fast / 3e7) ** 0.5, 1e5 * (fast / 3e7) ** 0.5,
                     scale='log'),
        ),
        dynamics=dynamics,
        output=lambda t, x, u, p: (x[0], x[2]),
    )  # fmt: skip


def all_a(rng: np.random.Generator, p: Array) -> Array:
    """Start from the first species alone."""
    return np.array([1.0, 0.0, 0.0])


def thermal(slowest: float, fastest: float, nodes: int = 20) -> Model:
    """Heat along a chain of nodes whose rates lie between two in 1/s, the fast ones first."""
    rates = np.geomspace(fastest, slowest, nodes)

    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        power, outside = u
        heating, exchange, loss = p
        out = []
        for i in range(nodes):
            flow = exchange * ((x[i - 1] - x[i]) if i else 0.0)
            flow += exchange * ((x[i + 1] - x[i]) if i + 1 < nodes else 0.0)
            flow += loss * (outside - x[i]) + (heating * power if i == 0 else 0.0)
            out.append(rates[i] * flow)
        return out

    return Model(
        name='thermal',
        states=tuple(Variable(f'T{i}', 'degC', 0.0, 100.0) for i in range(nodes)),
        inputs=(Variable('power', 'W'), Variable('outside', 'degC')),
        outputs=tuple(Variable(f'T{i}', 'degC') for i in range(0, nodes, 4)),
        parameters=(
            Variable('heating', 'K/W', 0.05, 1.0),
            Variable('exchange', '1', 0.2, 4.0),
            Variable('loss', '1', 0.01, 0.4),
        ),
        dynamics=dynamics,
        output=lambda t, x, u, p: [x[i] for i in range(0, nodes, 4)],
    )


def room_temperatures(rng: np.random.Generator, p: Array) -> Array:
    """Draw temperatures that differ a little."""
    return rng.uniform(30.0, 40.0) + rng.uniform(-2.0, 2.0, 20)


def buck(scale: float) -> Model:
    """A buck converter on average; its coil and capacitor are `scale` times 100 uH and 100 uF."""
    coil, capacitor = 1e-4 * scale, 1e-4 * scale

    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        current, voltage = x
        series, load, supply = p
        return (
            (u[0] * supply - voltage - series * current) / coil,
            (current - voltage / load) / capacitor,
        )

    return Model(
        name='buck',
        states=(Variable('current', 'A', -20, 40), Variable('voltage', 'V', -10, 60)),
        inputs=(Variable('duty', '1'),),
        outputs=(Variable('current', 'A'), Variable('voltage', 'V')),
        parameters=(
            Variable('series', 'ohm', 0.05, 1.0),
            Variable('load', 'ohm', 1.0, 20.0),
            Variable('supply', 'V', 10.0, 40.0),
        ),
        dynamics=dynamics,
        output=both,
    )


def enzyme(binding: float) -> Model:
    """Full kinetics of an enzyme whose binding takes 1/`binding` s, and no quasi-steady state."""

    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        substrate, complex_ = x
        on, off, turnover = p
        bound = binding * (on * (0.1 - complex_) * substrate - off * complex_)
        return u[0] - bound, bound - turnover * complex_

    return Model(
        name='enzyme',
        states=(Variable('substrate', 'mM', 0.0, 4.0), Variable('complex', 'mM', 0.0, 0.1)),
        inputs=(Variable('feed', 'mM/s'),),
        outputs=(Variable('substrate', 'mM'),),
        parameters=(
            Variable('on', '1/mM', 1.0, 30.0, scale='log'),
            Variable('off', '1', 0.3, 10.0, scale='log'),
            Variable('turnover', '1/s', 0.2, 3.0, scale='log'),
        ),
        dynamics=dynamics,
        output=first,
    )


def battery(fast: float) -> Model:
    """A cell with two pairs of resistor and capacitor, the fast one of `fast` s."""

    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        _, quick, slow = x
        _, r1, r2 = p
        return -u[0] / 7200.0, (r1 * u[0] - quick) / fast, (r2 * u[0] - slow) / 60.0

    def output(t: Any, x: Any, u: Any, p: Any) -> Any:
        open_circuit = 3.2 + 0.7 * x[0] + 0.3 * np.tanh(8.0 * (x[0] - 0.9))
        return (open_circuit - p[0] * u[0] - x[1] - x[2],)

    return Model(
        name='battery',
        states=(
            Variable('charge', '1', 0.1, 1.0),
            Variable('quick', 'V', -0.3, 0.3),
            Variable('slow', 'V', -0.3, 0.3),
        ),
        inputs=(Variable('current', 'A'),),
        outputs=(Variable('voltage', 'V'),),
        parameters=(
            Variable('r0', 'ohm', 0.005, 0.1),
            Variable('r1', 'ohm', 0.005, 0.1),
            Variable('r2', 'ohm', 0.005, 0.1),
        ),
        dynamics=dynamics,
        output=output,
    )


def reactor(jacket: float) -> Model:
    """An exothermic stirred tank, its jacket of a time constant of `jacket` s."""

    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        fresh, temperature, cooled = x
        rate, heat, exchange = p
        reaction = rate * np.exp(20.0 - 7000.0 / temperature) * fresh
        return (
            0.02 * (1.0 - fresh) - reaction,
            0.02 * (350.0 - temperature) + heat * reaction - exchange * (temperature - cooled),
            (u[0] - cooled) / jacket + 0.1 * exchange * (temperature - cooled),
        )

    return Model(
        name='reactor',
        states=(
            Variable('fresh', 'mol/l', 0.0, 1.0),
            Variable('temperature', 'K', 300.0, 450.0),
            Variable('cooled', 'K', 280.0, 360.0),
        ),
        inputs=(Variable('coolant', 'K'),),
        outputs=(Variable('temperature', 'K'), Variable('cooled', 'K')),
        parameters=(
            Variable('rate', '1/s', 0.003, 0.1, scale='log'),
            Variable('heat', 'K l/mol', 50.0, 300.0),
            Variable('exchange', '1/s', 0.01, 0.2),
        ),
        dynamics=dynamics,
        output=lambda t, x, u, p: (x[1], x[2]),
    )


def near_its_inlet(rng: np.random.Generator, p: Array) -> Array:
    """Draw a state of the reactor before it has lit."""
    return np.array([rng.uniform(0.6, 0.9), rng.uniform(330.0, 350.0), rng.uniform(295.0, 315.0)])


VOLTS = stairs((-12.0, 12.0))
PLANTS = {
    plant.name: plant
    for plant in (
        Plant('motor, L/R .1 ms', motor(1e-4), motor(5e-2), np.arange(150) * 0.01, VOLTS),
        Plant('motor, L/R 1 ms', motor(1e-3), motor(5e-2), np.arange(150) * 0.01, VOLTS),
        *(
            Plant(f'van der Pol {mu:g}', van_der_pol(mu), van_der_pol(1.0),
                  np.linspace(0.0, length, 101), start=on_the_cycle)
            for mu, length in ((1.0, 10.0), (10.0, 15.0), (100.0, 120.0), (1000.0, 1200.0))
        ),
        Plant('Robertson, even', robertson(3e7), robertson(30.0), np.linspace(0.0, 40.0, 101),
              start=all_a),
        Plant('Robertson, by decades', robertson(3e7), robertson(30.0),
              np.array([0.0, *np.geomspace(1e-4, 1e4, 100)]), start=all_a),
        Plant('thermal network', thermal(1e-4, 1e2), thermal(1e-2, 1.0), np.arange(101) * 1.0,
              stairs((0.0, 60.0), (0.0, 30.0)), room_temperatures),
        Plant('buck converter', buck(1.0), buck(30.0), np.arange(101) * 1e-3, stairs((0.2, 0.9))),
        Plant('enzyme', enzyme(1e3), enzyme(1.0), np.arange(101) * 0.25, stairs((0.0, 0.15))),
        Plant('battery', battery(0.02), battery(5.0), np.arange(121) * 1.0, stairs((-2.0, 4.0))),
        Plant('reactor', reactor(0.05), reactor(20.0), np.arange(121) * 1.0,
              stairs((285.0, 320.0)), near_its_inlet),
    )
}  # fmt: skip
