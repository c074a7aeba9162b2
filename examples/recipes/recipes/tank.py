"""A heated, stirred tank that loses heat to the room."""

from obs_ros import Model, Variable
from plant_sim.scenario import Scenario
from plant_sim.signals import Schedule


def dynamics(t, x, u, p):
    heater, room = u  # W, degC
    loss, capacity = p
    return ((heater - loss * (x[0] - room)) / (1e3 * capacity),)


TANK = Model(
    name='tank',
    states=(Variable('warm', 'degC', 0, 100),),
    inputs=(Variable('heater', 'W', nominal=1000), Variable('room', 'degC', nominal=20)),
    outputs=(Variable('warm', 'degC'),),
    parameters=(
        Variable('loss', 'W/K', lower=1, upper=200, nominal=20, scale='log'),
        Variable('capacity', 'kJ/K', lower=10, upper=2000, nominal=200, scale='log'),
    ),
    dynamics=dynamics,
    output=lambda t, x, u, p: (x[0],),
    reference='one stirred volume, losses by Newton',
)


def batch(t):
    """Return the heater in W, which a thermostat switches, and the room in degC."""
    return 2000.0 if t % 2400.0 < 1200.0 else 200.0, 20.0


HEATS = Scenario(
    name='heats',
    model='recipes.tank:TANK',
    initial_state=(30.0,),  # degC
    inputs=batch,
    parameters=Schedule((0.0, 21600.0), ((25.0, 210.0), (40.0, 210.0))),  # 6 h on, a lid stays open
    sample_period=20.0,  # s
    duration=43200.0,  # s
    snr_db=26.0,  # noise of 0.05 K
)
