"""Tests of obs_ros.observers.papers.adaptive_gains."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from obs_ros.models import load_model
from obs_ros.observers.papers.adaptive_gains import (
    BUILT_IN,
    gains_of,
    read_gains,
    stored_gains,
    write_gains,
)
from obs_ros.observers.papers.design.plants import suspension

SUSPENSION = load_model('suspension')
STORED = [(model, name) for model, kinds in BUILT_IN.items() for name in kinds]


@pytest.mark.parametrize(('model', 'name'), STORED)
def test_stored_gains_fit_their_model(model: str, name: str) -> None:
    known = load_model(model)
    gains = stored_gains(known, name)
    n, r = len(known.states), len(known.outputs)
    assert set(gains.parameters) <= {variable.name for variable in known.parameters}
    assert gains.L.shape == (n, r) and gains.H.shape == (gains.B.shape[1], r)
    assert gains.B.shape[0] == n and gains.scale.shape == (len(gains.parameters),)


@pytest.mark.parametrize('origin', ['designed', 'printed'])
def test_the_suspension_with_its_gains_is_stable(origin: str) -> None:
    plant, gain = suspension(), stored_gains(SUSPENSION, origin).L
    assert np.linalg.eigvals(plant.A - gain @ plant.C).real.max() < 0.0


def test_what_is_kept_reads_back_to_the_last_bit(tmp_path: Path) -> None:
    rng, path = np.random.default_rng(3), tmp_path / 'gains.json'
    gains = gains_of(SUSPENSION, ('kt', 'eta'), rng.normal(size=12), rng.normal(size=(4, 2)),
                     rng.normal(size=6), (1e5, 300.0), beta=1.0 / 3.0, origin='a test')  # fmt: skip
    write_gains(path, SUSPENSION, gains)
    read = read_gains(path, SUSPENSION)
    for name in ('L', 'B', 'H', 'scale'):
        np.testing.assert_array_equal(getattr(read, name), getattr(gains, name))
    assert (read.parameters, read.beta, read.origin) == (('kt', 'eta'), 1.0 / 3.0, 'a test')
    assert np.isnan(read.peak)
    assert stored_gains(SUSPENSION, str(path)).L.tolist() == gains.L.tolist()


def test_without_a_scale_it_is_the_width_of_the_bounds() -> None:
    gains = gains_of(SUSPENSION, ('eta', 'kt'), np.zeros(12))
    assert gains.scale.tolist() == [4000.0, pytest.approx(2.9 * 260000.0)]
    assert gains.B.size == gains.H.size == 0


@pytest.mark.parametrize(
    ('arguments', 'why'),
    [
        ((('kt',), np.zeros(11)), 'L has 11 entries: 4 x 3 needed'),
        ((('kt',), [np.nan] * 12), 'L must be finite numbers'),
        ((('kt',), np.zeros(12), np.ones(4)), 'give B and H together'),
        ((('kt',), np.zeros(12), np.ones(3), np.ones(3)), 'B has 3 entries: 4 x 1 needed'),
        ((('kt',), np.zeros(12), np.ones(8), np.ones(3)), 'H has 3 entries: 2 x 3 needed'),
        ((('kt',), np.zeros(12), (), (), (0.0,)), 'scale must be positive'),
        ((('ktt',), np.zeros(12)), "no parameter 'ktt': did you mean 'kt'"),
        ((('kt', 'kt'), np.zeros(12)), 'name each parameter to adapt once'),
        (((), np.zeros(12)), 'name each parameter to adapt once, not none'),
    ],
)
def test_gains_that_do_not_fit_are_refused(arguments: tuple[Any, ...], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        gains_of(SUSPENSION, *arguments)


GOOD = {'model': 'suspension', 'parameters': ['kt'], 'L': [[0.0] * 3] * 4}


@pytest.mark.parametrize(
    ('content', 'why'),
    [
        ('not JSON', 'Expecting value'),
        ('[]', 'no object of JSON'),
        (json.dumps({**GOOD, 'model': 'three_tank'}), "gains of model 'three_tank'"),
        (json.dumps({'model': 'suspension', 'L': []}), "no 'parameters'"),
        (json.dumps({**GOOD, 'gain': 1.0}), "unknown entry 'gain'"),
        (json.dumps({**GOOD, 'parameters': 'kt'}), 'no list of names'),
        (json.dumps({**GOOD, 'L': ['a']}), 'could not convert'),
        (json.dumps({**GOOD, 'L': [[0.0]]}), 'L has 1 entries'),
        (json.dumps({**GOOD, 'L': [10**400]}), 'too large'),
        (json.dumps({**GOOD, 'beta': 'small'}), 'could not convert'),
        ('[' * 100_000, 'not '),
        (' ' * 2_000_000, 'more than 1000000 bytes'),
    ],
)
def test_a_file_that_holds_no_gains_is_refused_with_its_path(
    tmp_path: Path, content: str, why: str
) -> None:
    path = tmp_path / 'gains.json'
    path.write_text(content)
    with pytest.raises(ValueError, match=why) as caught:
        read_gains(path, SUSPENSION)
    assert 'gains.json' in str(caught.value)


def test_a_missing_file_and_a_model_without_gains_say_what_to_do() -> None:
    with pytest.raises(ValueError, match=r"give the path of a file .*'nowhere\.json': .*No such"):
        stored_gains(SUSPENSION, 'nowhere.json')
    with pytest.raises(ValueError, match=r"design gains for model 'three_tank' .* suspension only"):
        stored_gains(load_model('three_tank'), 'designed')
