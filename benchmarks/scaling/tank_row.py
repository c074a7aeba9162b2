"""Rows of any number of tanks, generated: as many valves, every other level measured."""

import functools

from benchmarks.zoo import Case, tank_chain
from benchmarks.zoo.cases import steady
from obs_ros import Model

SAMPLES = 1000


@functools.cache
def tank_row(tanks: int) -> Case:
    """Return windows of a row of `tanks` tanks: twice as many unknowns."""
    return Case(
        f'{tanks} tanks', _model(tanks), SAMPLES, 1.0, 20.0, inputs=steady(30.0), unit_power=True
    )


def _model(tanks: int) -> Model:
    """Return the model; its functions are written out, as a compiled rollout needs them."""
    last = tanks - 1
    flows = [f'p[{i}] * FLOW * jet_speed(x[{i}] - x[{i + 1}])' for i in range(last)]
    flows.append(f'p[{last}] * FLOW * jet_speed(x[{last}])')
    lines = [f'    q{i} = {flow}' for i, flow in enumerate(flows)]
    rates = ['u[0] / TANK_AREA - q0', *(f'q{i - 1} - q{i}' for i in range(1, tanks))]
    levels = ''.join(f'x[{i}], ' for i in range(0, tanks, 2))
    scope = {name: getattr(tank_chain, name) for name in ('FLOW', 'TANK_AREA', 'jet_speed')}
    text = '\n'.join(
        [
            'def dynamics(t, x, u, p):',
            *lines,
            f'    return {", ".join(rates)}',
            'def output(t, x, u, p):',
            f'    return ({levels})',
        ]
    )
    exec(text, scope)
    return tank_chain._chain(tanks, scope['dynamics'], scope['output'])
