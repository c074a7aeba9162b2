"""A heater board as it was identified from records: the next temperature, a period of 2 s later."""

from obs_ros import Model, Variable


def next_state(t, x, u, p):
    warm, power = x  # K above the room; the power of one period before, in %
    keep, gain = p
    return keep * warm + gain * power, u[0]


HEATER = Model(
    name='heater',
    kind='discrete',
    period=2.0,  # s
    states=(Variable('warm', 'K', lower=-10, upper=90), Variable('power', '%', -20, 120)),
    inputs=(Variable('heater', '%', nominal=30),),
    outputs=(Variable('warm', 'K'),),
    parameters=(
        Variable('keep', lower=0.8, upper=1, nominal=0.95),
        Variable('gain', 'K/%', lower=0, upper=0.2, nominal=0.05),
    ),
    dynamics=next_state,
    output=lambda t, x, u, p: (x[0],),
)
