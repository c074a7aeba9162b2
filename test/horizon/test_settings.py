"""Tests of obs_ros.horizon.settings."""

import inspect
from dataclasses import FrozenInstanceError, fields, replace

import pytest
from plants import LAG

from obs_ros import solve_window
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.horizon.settings import EstimationSettings, with_starts, without_process_noise
from obs_ros.horizon.solver import Solver
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.optimization.methods import METHODS


def test_the_front_door_has_every_setting_with_the_same_default() -> None:
    front = inspect.signature(solve_window).parameters
    for field in fields(EstimationSettings):
        default = getattr(EstimationSettings(), field.name)
        assert (front[field.name].default or None) == (default or None), field.name
    others = set(front) - {field.name for field in fields(EstimationSettings)}
    assert others == {'model', 'record', 'seed', 'deadline', 'previous'}


def test_they_are_documented_and_do_not_change() -> None:
    settings = EstimationSettings(fitness='euclidean')
    for field in fields(settings):
        assert f'`{field.name}`' in str(EstimationSettings.__doc__)
    with pytest.raises(FrozenInstanceError):
        settings.fitness = 'least_squares'  # type: ignore[misc]
    with pytest.raises(TypeError, match='fitnes'):
        EstimationSettings(fitnes='euclidean')  # type: ignore[call-arg]


def test_a_start_begins_at_the_means_of_priors_but_for_what_is_given() -> None:
    model = with_knowledge(LAG, None, {'k': (2.0, 0.1), 'x': (0.5, 0.2)})
    unknowns = Unknowns.of(model)
    found = with_starts(EstimationSettings(initial={'k': 3.0}), unknowns)
    assert found.initial == {'x': 0.5, 'k': 3.0}
    assert with_starts(EstimationSettings(), Unknowns.of(LAG)).initial == {}
    held = Unknowns.of(model, fixed={'k': 1.0})
    with pytest.raises(ValueError, match='k cannot have a prior: it is not estimated'):
        with_starts(EstimationSettings(priors={'k': (2.0, 0.1)}), held)
    with pytest.raises(ValueError, match='k cannot have an initial value: it is not estimated'):
        with_starts(EstimationSettings(initial={'k': 2.0}), held)
    # Taken away, or the model's own: nothing to complain of.
    assert with_starts(EstimationSettings(priors={'k': None}), held).initial['x'] == 0.5


def test_process_noise_goes_without_delays_that_are_estimated() -> None:
    model = replace(
        LAG,
        states=[replace(v, walk=0.1) for v in LAG.states],
        outputs=[replace(v, delay=(0.0, 0.5)) for v in LAG.outputs],
    )
    assert Solver.of(model).settings.process_noise == 'off'
    with pytest.raises(ValueError, match=r"to 'off', not 'given': y.delay is estimated, which no"):
        Solver.of(model, EstimationSettings(process_noise='given'))
    assert Solver.of(LAG).settings.process_noise == 'auto'
    search = EstimationSettings(search='ga', process_noise='given')
    assert 'does without squares' in without_process_noise(search, LAG, METHODS['ga'])
