import math

import pytest

from obs_ros.replay.parameter_file import LARGEST, parse_assignment, read_parameters

FILE = """
/**:
  ros__parameters:
    seed: 3
    use_sim_time: true
/**/estimator:
  ros__parameters:
    window:
      duration: 2e1
      period: 5
    parameters: [p1, p2]
    bounds:
      p1: [0.1, 1.0]
    fixed.p3: .nan
    seed: 4
/line_1/estimator:
  ros__parameters: {seed: 5}
/**/simulator:
  ros__parameters: {seed: 6}
"""


def write(tmp_path, text):
    path = tmp_path / 'params.yaml'
    path.write_text(text)
    return path


def test_a_file_of_ros_means_what_it_means_to_the_node(tmp_path):
    values = read_parameters(write(tmp_path, FILE))
    assert math.isnan(values.pop('fixed.p3'))
    assert values == {
        'seed': 4,
        'use_sim_time': True,
        'window.duration': 20.0,
        'window.period': 5,
        'parameters': ['p1', 'p2'],
        'bounds.p1': [0.1, 1.0],
    }


@pytest.mark.parametrize(
    ('node', 'seed'),
    [('/estimator', 4), ('/line_1/estimator', 5), ('/a/b/estimator', 4), ('/x', 3)],
)
def test_names_and_wildcards_choose_the_node(tmp_path, node, seed):
    assert read_parameters(write(tmp_path, FILE), node)['seed'] == seed


@pytest.mark.parametrize('name', ['y', 'n', 'on', 'no', 'null', '1e3', '0x10', 'true'])
def test_a_name_is_one_though_yaml_has_another_meaning_of_it(tmp_path, name):
    text = f'/**:\n  ros__parameters:\n    noise: {{{name}: 0.1}}\n    {name}: on\n'
    assert read_parameters(write(tmp_path, text)) == {f'noise.{name}': 0.1, name: True}


@pytest.mark.parametrize('key', ['estimator', '/estimator', '/*', '/**', '/**/est*'])
def test_a_node_is_named_in_many_ways(tmp_path, key):
    text = f'{key}:\n  ros__parameters:\n    a: 1\n'
    assert read_parameters(write(tmp_path, text)) == {'a': 1}


def test_namespaces_may_nest(tmp_path):
    path = write(tmp_path, 'line:\n  estimator:\n    ros__parameters: {a: 1}\n')
    assert read_parameters(path, '/line/estimator') == {'a': 1}
    with pytest.raises(ValueError, match=r'nothing for the node /estimator; .*: /line/estimator'):
        read_parameters(path)


@pytest.mark.parametrize(
    ('text', 'value'),
    [
        ('1e-3', 1e-3), ('-4', -4), ('.inf', math.inf), ('yes', True), ('n', False),
        ('1:30', '1:30'), ('2020-01-01', '2020-01-01'), ('1_000', '1_000'), ('"5"', '5'),
        ('[1, 2.5]', [1, 2.5]), ('my_plant:MODEL', 'my_plant:MODEL'), ('0x10', 16),
    ],
)  # fmt: skip
def test_words_are_what_they_are_to_ros(text, value):
    assert parse_assignment(f'a.b:={text}') == ('a.b', value)


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('a: [1, 2', r'params.yaml:1: '),
        ('/**:\n  ros__parameters:\n    a: !!python/object/apply:os.getcwd []', 'params.yaml:3: '),
        ('/**:\n  ros__parameters:\n    a: &x [1]\n    b: *x', 'params.yaml:4: aliases'),
        ('- 1', 'not a parameter file'),
        ('window: 3', "/window is 3, but parameters stand under ros__parameters"),
        ('/**:\n  ros__parameters: 3', 'must hold names with values, not 3'),
        ('\x00', 'no valid YAML'),
        ('a:' * 100, 'params.yaml'),
        ('[' * 5000, 'params.yaml'),
    ],
)  # fmt: skip
def test_what_is_no_parameter_file_is_refused_with_its_place(tmp_path, text, message):
    with pytest.raises(ValueError, match=message):
        read_parameters(write(tmp_path, text))


def test_a_huge_file_is_not_read(tmp_path):
    with pytest.raises(ValueError, match=f'more than {LARGEST} bytes'):
        read_parameters(write(tmp_path, '#' * (LARGEST + 1)))
