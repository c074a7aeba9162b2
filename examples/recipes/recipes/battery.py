"""A battery cell on a driving cycle: open-circuit voltage, series resistance, one RC pair."""

from obs_ros import Model, Variable
from plant_sim.scenario import Scenario
from plant_sim.signals import Schedule


def dynamics(t, x, u, p):
    _, relaxing = x  # V
    _, r1, tau, slope = p
    return -slope * u[0] / 3600, (1e-3 * r1 * u[0] - relaxing) / tau


def output(t, x, u, p):
    return (x[0] - x[1] - 1e-3 * p[0] * u[0],)


CELL = Model(
    name='cell',
    states=(Variable('ocv', 'V', 3.0, 3.6), Variable('relaxing', 'V', -0.2, 0.2, nominal=0)),
    inputs=(Variable('current', 'A', nominal=0),),
    outputs=(Variable('voltage', 'V'),),
    parameters=(
        Variable('r0', 'mohm', lower=0.05, upper=10, nominal=1, scale='log'),
        Variable('r1', 'mohm', lower=0.05, upper=10, nominal=1, scale='log'),
        Variable('tau', 's', lower=2, upper=200, nominal=20, scale='log'),
        Variable('slope', 'V/Ah', lower=0, upper=0.2, nominal=0.02, physical='lower'),
    ),
    dynamics=dynamics,
    output=output,
    reference='equivalent circuit with one RC pair',
)

CURRENTS = (40.0, 90.0, -30.0, 60.0, 0.0, 120.0, 20.0, -60.0, 80.0, 10.0, 50.0)  # A, each for 7 s


def driving(t):
    return (CURRENTS[int(t / 7.0) % len(CURRENTS)],)


DRIVE = Scenario(
    name='drive',
    model='recipes.battery:CELL',
    initial_state=(3.33, 0.0),  # V
    inputs=driving,
    # After a quarter of an hour a contact comes loose: r0 rises by 0.4 mohm.
    parameters=Schedule((0.0, 900.0), ((0.8, 0.5, 25.0, 0.015), (1.2, 0.5, 25.0, 0.015))),
    sample_period=0.5,  # s
    duration=1800.0,  # s
    snr_db=60.0,  # noise of 0.001 V
)
