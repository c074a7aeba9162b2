import pytest

from obs_ros.studies.variants import MOST_VARIANTS, axis, shown, variants

GIVEN = {'model': 'three_tank', 'window.duration': 200.0}


def test_every_combination_is_a_variant_the_last_name_fastest():
    found = variants(GIVEN, ['window.duration=100,300', 'process_noise=off,auto'])
    assert [str(each) for each in found] == [
        'window.duration=100, process_noise=off',
        'window.duration=100, process_noise=auto',
        'window.duration=300, process_noise=off',
        'window.duration=300, process_noise=auto',
    ]
    assert [each.setup.values['window.duration'] for each in found] == [100.0, 100.0, 300.0, 300.0]
    assert {each.setup.values['process_noise'] for each in found} == {'off', 'auto'}
    assert all(each.given['model'] == 'three_tank' for each in found)


def test_without_values_to_vary_there_is_the_one_that_is_given():
    (only,) = variants(GIVEN, [])
    assert (str(only), only.varied, only.given) == ('as given', {}, GIVEN)


@pytest.mark.parametrize(
    ('text', 'values'),
    [
        ('seed=0,1,2', [0, 1, 2]),
        ('window.period:=1e1', [10.0]),
        ('observer=ekf,my_package.mine:CLASS', ['ekf', 'my_package.mine:CLASS']),
        ('parameters=[p1, p2],[all]', [['p1', 'p2'], ['all']]),
    ],
)
def test_values_are_read_as_in_a_parameter_file(text, values):
    assert axis(text)[1] == values


@pytest.mark.parametrize(
    ('asked', 'message'),
    [
        (['window.duration'], "--vary 'window.duration' is not of the form NAME=A,B"),
        (['seed='], 'is not of the form NAME=A,B'),
        (['sed=1,2'], "--vary: there is no parameter 'sed'"),
        (['process_noise=off,sometimes'], "unknown process_noise 'sometimes'"),
        (['seed=1,1'], '--vary: seed=1 is there twice'),
        (['seed=1', 'seed=2'], 'give all values of a parameter at once'),
        (['seed=[1'], '--vary seed:1: '),
        (['window.duration=1,1e9'], 'shorten window.duration'),
        ([f'seed={",".join(map(str, range(MOST_VARIANTS + 1)))}'], '1001 variants, of at most'),
    ],
)
def test_what_is_wrong_is_told_before_anything_runs(asked, message):
    with pytest.raises(ValueError) as told:
        variants({**GIVEN, 'max_step': 0.1}, asked)
    assert message in str(told.value)


def test_values_are_shown_as_they_are_given():
    assert [shown(v) for v in (True, 0.5, 300.0, 'off', ('p1', 'p2'), (1.0, 2.5))] == [
        'true', '0.5', '300', 'off', '[p1, p2]', '[1, 2.5]'
    ]  # fmt: skip
