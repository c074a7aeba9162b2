"""The plants that searches are tried on."""

import numpy as np
import pytest

from benchmarks.zoo import MANY_UNKNOWNS, draw
from benchmarks.zoo.networks import AMBIENT, HEAT, masses, rooms
from benchmarks.zoo.tank_chain import tank_chain
from obs_ros.models.three_tank import FLOW, TANK_AREA


@pytest.mark.parametrize('n', [2, 5, 8])
def test_a_row_of_tanks_keeps_what_flows(n):
    model = tank_chain(n)
    rng = np.random.default_rng(n)
    x, p = rng.uniform(5.0, 95.0, n), rng.uniform(0.2, 1.0, n)
    heads = x - np.append(x[1:], 0.0)
    flows = p * FLOW * np.sign(heads) * np.sqrt(2.0 * 981.0 * np.abs(heads))
    fed = np.append(30.0 / TANK_AREA, flows[:-1])
    np.testing.assert_allclose(model.dynamics(0.0, x, [30.0], p), fed - flows)
    assert model.output(0.0, x, [30.0], p) == tuple(x[::2])
    assert len(model.variables) == 2 * n


@pytest.mark.parametrize('count', [1, 2, 15])
def test_masses_in_a_row_turn_work_into_energy_and_lose_what_dampers_take(count):
    model = masses(count)
    rng = np.random.default_rng(count)
    x, v = rng.uniform(-2.0, 2.0, (2, count))
    k, d = rng.uniform(20.0, 150.0, count), rng.uniform(0.0, 2.0, count)
    point = [*x, *v], [3.0], [*k, *d]
    moves, pushes = np.split(np.array(model.dynamics(0.0, *point)), 2)
    stretched = np.diff(x, prepend=0.0)
    power = v @ pushes + (k * stretched) @ np.diff(v, prepend=0.0)
    np.testing.assert_array_equal(moves, v)
    assert power == pytest.approx(3.0 * v[-1] - d @ v**2)
    assert list(model.output(0.0, *point)) == x.tolist()
    assert len(model.variables) == 4 * count


@pytest.mark.parametrize('count', [2, 5, 30])
def test_rooms_in_a_row_lose_heat_to_the_outside_alone(count):
    model = rooms(count)
    rng = np.random.default_rng(count)
    x, p = rng.uniform(0.0, 50.0, count), rng.uniform(0.05, 1.0, count)
    rates = np.array(model.dynamics(0.0, [*x], [0.7, 0.4], [*p]))
    assert HEAT * rates.sum() == pytest.approx(1.1 - p[-1] * (x[-1] - AMBIENT))
    rest = model.dynamics(0.0, [AMBIENT] * count, [0.0, 0.0], [*p])
    np.testing.assert_array_equal(rest, np.zeros(count))
    assert list(model.output(0.0, [*x], [0.7, 0.4], [*p])) == x[::2].tolist()
    assert len(model.variables) == 2 * count


@pytest.mark.slow
@pytest.mark.parametrize('name', MANY_UNKNOWNS)
def test_cases_of_many_unknowns_are_named_by_them_and_stay_within_their_bounds(name):
    case = MANY_UNKNOWNS[name]
    assert f' {len(case.model.variables)} unknowns' in name
    record, noise, truth = (getattr(draw(case, 5), each) for each in ('record', 'noise', 'truth'))
    assert len(set(noise.values())) == 1  # the judge weights all outputs alike
    for variable in case.model.variables:
        assert variable.lower < truth[variable.name] < variable.upper
    bounds = {v.name: v for v in case.model.states}
    for values, output in zip(record.y.T, case.model.outputs, strict=True):
        assert bounds[output.name].lower < values.min() < values.max() < bounds[output.name].upper
