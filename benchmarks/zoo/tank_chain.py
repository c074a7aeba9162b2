"""Tanks in a row, fed at the first, drained at the last; every other level is measured.

Every valve's opening and every level is unknown: of n tanks 2 n unknowns, with a long flat valley.
"""

from typing import Any

from obs_ros import Model, Variable
from obs_ros.models.three_tank import FLOW, TANK_AREA, jet_speed


def tank_chain(n: int) -> Model:
    """Return the model of n tanks; its functions are written out, as a compiled rollout needs."""
    flows = [f'    q{i} = p[{i}] * FLOW * jet_speed(x[{i}] - x[{i + 1}])' for i in range(n - 1)]
    flows.append(f'    q{n - 1} = p[{n - 1}] * FLOW * jet_speed(x[{n - 1}])')
    rates = ['u[0] / TANK_AREA - q0', *(f'q{i - 1} - q{i}' for i in range(1, n))]
    levels = ''.join(f'x[{i}], ' for i in range(0, n, 2))
    lines = ['def dynamics(t, x, u, p):', *flows, f'    return {", ".join(rates)}']
    lines += ['def output(t, x, u, p):', f'    return ({levels})']
    scope: dict[str, Any] = {'FLOW': FLOW, 'TANK_AREA': TANK_AREA, 'jet_speed': jet_speed}
    exec('\n'.join(lines), scope)
    return Model(
        name=f'tank_chain_{n}',
        states=tuple(Variable(f'h{i}', unit='cm', lower=0.0, upper=100.0) for i in range(n)),
        inputs=(Variable('Q', unit='cm3/s', nominal=30.0),),
        outputs=tuple(Variable(f'h{i}', unit='cm') for i in range(0, n, 2)),
        parameters=tuple(Variable(f'p{i}', lower=0.0, upper=1.0, nominal=0.5) for i in range(n)),
        dynamics=scope['dynamics'],
        output=scope['output'],
        max_step=1.0,
    )
