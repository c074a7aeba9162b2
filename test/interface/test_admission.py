"""What anybody may give a node before it is configured."""

import sys

import pytest

from obs_ros.interface.admission import check_admitted

GIVEN = {
    'model': 'my_plant.pendulum:PENDULUM', 'signals.h1.type': 'planted/msg/Type',
    'checkpoint': '/var/lib/tank',
}  # fmt: skip


@pytest.mark.parametrize(
    ('name', 'value'),
    [
        ('model', 'three_tank'), ('model', GIVEN['model']), ('model', None), ('observer', 'ekf'),
        ('signals.h1.type', GIVEN['signals.h1.type']), ('signals.h1.topic', '/somewhere'),
        ('window.duration', 'whatever: configure says so'), ('bounds.p1', [0.0, 1.0]),
        ('merge_wait', 1), ('checkpoint', GIVEN['checkpoint']), ('checkpoint', ''),
        ('checkpoint', None),
    ],
)  # fmt: skip
def test_own_code_what_was_given_at_start_and_all_that_is_no_code_is_admitted(name, value):
    check_admitted(name, value, GIVEN)


@pytest.mark.parametrize(
    ('name', 'value', 'reason'),
    [
        ('model', 'my_plant.pendulum:OTHER', 'start the node with model'),
        ('model', 'os:system', 'start the node with model'),
        ('observer', 'my_plant.pendulum:PENDULUM', 'start the node with observer'),
        ('observer', 'subprocess:Popen', 'start the node with observer'),
        ('signals.h2.type', 'planted/msg/Type', 'start the node with signals.h2.type'),
        ('managed', False, 'start the node anew'),
        ('managed', None, 'start the node anew'),
        ('checkpoint', '/home/me/notes.txt', 'only whoever starts it names a file'),
        ('checkpoint', '/var/lib/tank2', 'start the node with checkpoint'),
        ('model', 7, 'model must be text'),
        ('merge_wait', 61.0, 'merge_wait must be 0 to 60 s'),
        ('signals.h1.topic', 'x' * 201, 'at most 200 characters'),
        ('parameters', ['p1', 'x' * 201], 'at most 200 characters'),
        ('bounds.p1', [0.0] * 1001, 'at most 1000 entries'),
    ],
)
def test_all_else_is_refused_with_what_to_do(name, value, reason):
    with pytest.raises(ValueError, match=reason):
        check_admitted(name, value, GIVEN)


def test_types_of_packages_that_are_loaded_import_nothing(monkeypatch):
    name, value = 'signals.h1.type', 'loaded/msg/Type'
    with pytest.raises(ValueError, match='only whoever starts it names code'):
        check_admitted(name, value, {})
    monkeypatch.setitem(sys.modules, 'loaded.msg', sys)
    check_admitted(name, value, {})
