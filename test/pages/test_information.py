import pytest
import yaml

from obs_ros.pages.information import (
    LONGEST_INFO,
    LONGEST_OUTCOME,
    MOST_NAMES,
    Concluded,
    Information,
    Shown,
    concluded,
    information,
)

INFO = {
    'model': 'tank',
    'states': [{'name': 'h', 'unit': 'cm', 'bounds': [0.0, 1.0]},
               {'name': 'angle', 'unit': '1', 'period': 360.0}],
    'inputs': [], 'outputs': [{'name': 'h', 'unit': 'cm'}], 'parameters': [{'name': 'p'}],
    'settings': {'observer': 'ekf', 'seed': 0},
}  # fmt: skip


def told(**changes):
    return information(yaml.safe_dump(INFO | changes))


def test_variables_are_read():
    found = told()
    assert (found.model, found.observer) == ('tank', 'ekf')
    assert found.states == (Shown('h', 'cm'), Shown('angle', '', 360.0))
    assert found.outputs == (Shown('h', 'cm'),) and found.parameters == (Shown('p'),)
    assert found.inputs == () and found.left_out == 0


def test_names_are_bounded_and_what_is_left_out_is_counted():
    many = [{'name': f'x{k}'} for k in range(MOST_NAMES + 5)]
    found = told(states=many, parameters=[{'name': 'n' * 101}, {'name': 'q'}])
    assert len(found.states) == MOST_NAMES and found.left_out == 5
    assert found.parameters == (Shown('q'),)


@pytest.mark.parametrize('text', [
    '', '[', 'a: !!python/object:os.system {}', '- 1', 'settings: {}', 'settings: {plants: []}',
    'x' * (LONGEST_INFO + 1), '[' * 2000,
])  # fmt: skip
def test_what_no_estimator_writes_is_refused(text):
    with pytest.raises(ValueError):
        information(text)


@pytest.mark.parametrize('wrong', [None, 3, 'h', {'name': 'h'}, [3, None, {'unit': 'cm'}]])
def test_variables_of_another_form_are_none(wrong):
    assert told(states=wrong).states == ()


@pytest.mark.parametrize('period', ['round', True, -1.0, float('inf'), float('nan'), [1]])
def test_a_period_that_is_none_is_left_alone(period):
    assert told(states=[{'name': 'h', 'period': period}]).states == (Shown('h'),)


# 10 to the power of 9 texts, were anybody to write them out.
ALIASES = 'a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n' + ''.join(
    f'a{k}: &a{k} [{", ".join([f"*a{k - 1}"] * 10)}]\n' for k in range(1, 9)
)


def test_texts_that_only_aliases_make_long_are_nothing():
    head = 'model: *a8\nstates: [{name: h, unit: *a8}, {name: *a8}]\n'
    found = information(f'{ALIASES}{head}settings: {{observer: *a8}}\n')
    assert found == Information('', '', states=(Shown('h'),))


# A mapping with 10 to the power of 9 entries, were they merged one by one.
MERGED = 'a0: &a0 {k: 1}\n' + ''.join(
    f'a{k}: &a{k} {{<<: [{", ".join([f"*a{k - 1}"] * 10)}]}}\n' for k in range(1, 10)
)


@pytest.mark.parametrize('read', [information, concluded])
def test_mappings_that_merging_makes_long_are_refused_before_they_are_made(read):
    with pytest.raises(ValueError, match='is no YAML'):
        read(f'{MERGED}settings: {{observer: ekf}}\nstamp_ns: 1\n')


def test_an_outcome_is_read():
    text = yaml.safe_dump({'stamp_ns': 7, 'outcome': 'converged', 'message': 'as told'})
    assert concluded(text) == Concluded(7, 'converged', 'as told')
    assert concluded('stamp_ns: -3') == Concluded(-3, '', '')


@pytest.mark.parametrize('text', ['', '- 1', 'outcome: x', 'stamp_ns: x', 'stamp_ns: 1.0',
                                  f'stamp_ns: 0x{"f" * 400}', f'stamp_ns: -{2**63}'])  # fmt: skip
def test_an_outcome_without_a_stamp_is_none(text):
    assert concluded(text) is None


@pytest.mark.parametrize('text', ['[', 'x' * (LONGEST_OUTCOME + 1), '[' * 2000])
def test_an_outcome_that_is_no_yaml_is_refused(text):
    with pytest.raises(ValueError, match='~/outcome'):
        concluded(text)
