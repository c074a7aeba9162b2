"""Texts on parameters fit a terminal, and leave none out."""

import pytest

from obs_ros.core.parameter_spec import ParameterSpec
from obs_ros.interface.parameters import CHOICE, COMMON, LIVE
from obs_ros.interface.usage import node_usage, settings_page, usage
from obs_ros.observers.base import OBSERVERS, load_observer


def test_the_help_of_a_node_names_defaults_families_and_more():
    rows = [ParameterSpec('on', True, 'run'), ParameterSpec('table', (1.0,), 'numbers', 's')]
    text = node_usage('thing', 'Does something.', rows, {'noise.NAME': 'deviation'}, ['More.'])
    assert text.splitlines()[:3] == [
        'usage: ros2 run obs_ros thing [--ros-args [-p NAME:=VALUE] [--params-file FILE] '
        '[-r FROM:=TO]]',
        '',
        'Does something.',
    ]
    assert '  on (true)\n    run\n  table ([1.0])\n    numbers (in s)\n' in text
    assert '  noise.NAME\n    deviation\n\nMore.\n' in text


def test_the_help_of_the_estimator_has_every_parameter_in_lines_of_100():
    lines = usage().splitlines()
    assert max(map(len, lines)) <= 100
    for row in (*CHOICE, *LIVE, *COMMON):
        assert any(line.startswith(f'  {row.name} (') for line in lines), row.name


@pytest.mark.parametrize('name', OBSERVERS)
def test_the_page_of_settings_is_on_observers_of_samples(name):
    assert (f'## {name}\n' in settings_page()) == load_observer(name).immediate
