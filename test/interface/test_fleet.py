"""A fleet in plain numbers: names of plants, and its health."""

import pytest

from obs_ros.interface.fleet import FLEET, MOST_PLANTS, FleetHealth, PlantStatus, plants, usage
from obs_ros.interface.status import Level

FINE = PlantStatus(estimates=3, lag=0.2)


def test_namespaces_are_taken_as_they_stand_and_one_empty_name_is_none():
    assert plants(('/line1/tank_a', '/b2', '/')) == ('/line1/tank_a', '/b2', '/')
    assert plants(('',)) == ()
    assert len(plants([f'/p{k}' for k in range(MOST_PLANTS)])) == 256


@pytest.mark.parametrize(
    ('names', 'advice'),
    [
        (['/a', '/b', '/a'], "'/a' stands twice: take one"),
        (['a'], "name each as '/line1/tank_a'.*not 'a'"),
        (['/a/'], "not '/a/'"),
        (['/a b'], 'letters, digits and _'),
        (['/1a'], 'no digit first'),
        (['/a', ''], "not ''"),
        (['/a//b'], "not '/a//b'"),
        (['/' + 'x' * 100_000], '100 characters at most'),
        ([f'/p{k}' for k in range(257)], 'start a second fleet for some of them: 257'),
    ],
)
def test_other_names_are_refused_with_advice_in_one_short_line(names, advice):
    with pytest.raises(ValueError, match=advice) as error:
        plants(names)
    assert len(str(error.value)) < 400 and '\n' not in str(error.value)


def test_figures_count_since_the_last_look():
    health = FleetHealth(workers=2)
    health.examine({'/a': FINE, '/b': FINE}, {}, [], 1.0)
    now = {'/a': PlantStatus(7, 1, 0.3), '/b': PlantStatus(5, 0, 0.7), '/c': PlantStatus(9, 2)}
    found = health.examine(now, {}, [], 2.0)
    assert found.figures == {
        'plants': 3, 'workers': 2, 'estimates_per_second': 3.0, 'slowest': '/b',
        'slowest.lag_s': 0.7, 'skipped': 3, 'skipped./a': 1, 'skipped./c': 2,
    }  # fmt: skip
    assert found.level is Level.WARN
    assert found.message.startswith('windows skipped: give it more workers or a longer')
    assert found.message.endswith(': /a')
    found = health.examine({'/a': PlantStatus(8, 1)}, {}, [], 1.0)
    assert (found.level, found.figures['estimates_per_second']) == (Level.OK, 1.0)


@pytest.mark.parametrize(
    ('running', 'refused', 'twice', 'level', 'message'),
    [
        ({'/a': FINE}, {}, [], Level.OK, '1 plants, the slowest estimate took 0.2 s'),
        ({}, {}, [], Level.WARN, 'no plants: set plants'),
        ({'/a': FINE}, {'/b': '/b: no'}, [], Level.ERROR, 'not started: /b: /b: no'),
        ({'/a': PlantStatus(error='oh')}, {}, [], Level.ERROR, 'failing: /a: oh'),
        ({'/a': FINE}, {}, ['/a/estimator'], Level.WARN, 'end one of two nodes of the same name'),
        ({'/a': FINE, '/b': PlantStatus(lag=1.5)}, {}, [], Level.WARN, '/b is 1.5 s behind'),
    ],
)
def test_the_worst_is_said(running, refused, twice, level, message):
    found = FleetHealth(workers=1).examine(running, refused, twice, 1.0)
    assert found.level is level
    assert found.message.startswith(message)


def test_figures_by_plant_are_few_however_many_there_are():
    many = {f'/p{k}': PlantStatus(skipped=1) for k in range(256)}
    found = FleetHealth(workers=1).examine(many, dict.fromkeys(many, 'no'), [], 1.0)
    assert len(found.figures) < 50 and found.figures['skipped'] == 256
    assert len(found.message) < 5000


def test_the_help_names_every_parameter_in_lines_of_100():
    lines = usage().splitlines()
    assert max(map(len, lines)) <= 100
    for row in FLEET:
        assert any(line.startswith(f'  {row.name} (') for line in lines), row.name
