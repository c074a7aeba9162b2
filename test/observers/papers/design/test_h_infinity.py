"""Tests of the gains' design: what is solved needs cvxpy, what checks a solution does not."""

from pathlib import Path

import numpy as np
import pytest
from extras import needs

from obs_ros.models import load_model
from obs_ros.observers.papers.adaptive_gains import read_gains, stored_gains
from obs_ros.observers.papers.design import h_infinity as design_module
from obs_ros.observers.papers.design.h_infinity import (
    Gains,
    checked,
    design,
    import_cvxpy,
    main,
)
from obs_ros.observers.papers.design.peak_gain import peak_gain
from obs_ros.observers.papers.design.plants import LipschitzPlant, suspension
from obs_ros.observers.papers.h_infinity import HInfinityObserver

NOISE = 0.01 / 300.0
STORED = stored_gains(load_model('suspension'), 'designed')


def test_without_cvxpy_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(__import__('sys').modules, 'cvxpy', None)
    with pytest.raises(ImportError, match='pip install cvxpy clarabel'):
        import_cvxpy()
    assert main([]) == 1
    assert 'refused: the design of H-infinity gains needs cvxpy' in capsys.readouterr().out


def first_order() -> LipschitzPlant:
    """x' = -2 x + 0.5 sin x + eta, y = x."""
    one = np.ones((1, 1))
    return LipschitzPlant(-2.0 * one, one, one, one, one, 0.5, np.ones(1), 1.0)


@pytest.mark.parametrize(
    ('p', 's', 'bound', 'inequality', 'why'),
    [
        (-1.0, 3.0, 1.0, -1.0, 'indefinite P'),
        (1.0, 3.0, 1.0, 0.1, 'does not hold: largest eigenvalue 0.1'),
        (1.0, -3.0, 1.0, -1.0, 'not stable: a pole lies at 1 1/s'),
        (1.0, 3.0, 0.2, -1.0, 'above the bound beta = 0.2'),
    ],
)
def test_a_solution_that_is_none_is_refused(
    p: float, s: float, bound: float, inequality: float, why: str
) -> None:
    one = np.ones((1, 1))
    with pytest.raises(ValueError, match=why):
        checked(first_order(), p * one, s * one, bound, inequality * one, False)


def test_an_equality_that_fails_is_refused() -> None:
    plant = suspension(share=None)
    injection = plant.C.T @ np.diag([500.0, 500.0, 0.0])
    injection[[1, 3]] = [[1e3, 0.0, 0.0], [0.0, 1e3, 0.0]]
    with pytest.raises(ValueError, match="B'P = HC does not hold"):
        checked(plant, np.eye(4), injection, 1e9, -np.eye(4), True)


def test_the_stored_gains_have_the_peak_that_is_stored_with_them() -> None:
    plant = suspension()
    assert peak_gain(plant, STORED.L) == pytest.approx(STORED.peak, rel=1e-4)
    open_loop = peak_gain(plant, 0.0 * STORED.L)
    assert STORED.peak < STORED.beta < open_loop
    poles = np.linalg.eigvals(plant.A - STORED.L @ plant.C).real
    assert poles.min() > -200.0 and poles.max() < -5.0


@pytest.mark.parametrize(
    ('arguments', 'why'),
    [
        (['--model', 'three_tank'], 'give --parameters NAME'),
        (['--model', 'three_tank', '--parameters', 'p1', '--printed'], 'leave --printed'),
        (['--model', 'three_tank', '--parameters', 'q1'], "no parameter 'q1'"),
        (['--disturbances', 'eta'], 'leave --disturbances out'),
        (['--model', 'nowhere'], "unknown model 'nowhere'"),
    ],
)
def test_a_command_that_does_not_go_together_is_refused(
    arguments: list[str], why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 1
    assert why in capsys.readouterr().out


def test_gains_that_cannot_be_kept_are_refused_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    model, one = load_model('suspension'), np.eye(4)
    found = Gains(STORED.L, STORED.B, STORED.H, one, 1.0, 0.5, 0.0, np.array([-1.0]))
    monkeypatch.setattr(design_module, 'designed', lambda given: (model, ('kt',), found))
    path = tmp_path / 'missing' / 'gains.json'
    assert main(['--keep', str(path)]) == 1
    *_, last = capsys.readouterr().out.splitlines()
    assert last.startswith('refused: give --keep a file that can be written: ')
    assert last.endswith(f'No such file or directory: {str(path)!r}')


@pytest.fixture
def solver() -> None:
    needs('cvxpy', 'test-design')
    needs('clarabel', 'test-design')


@pytest.mark.usefixtures('solver')
class TestWithClarabel:
    def test_the_printed_inequality_has_no_solution(self) -> None:
        """CB = 0, so B'P = HC forces B'PB = P44 = HCB = 0 and P cannot be positive definite."""
        with pytest.raises(ValueError, match=r"no solution: Clarabel says 'infeasible"):
            design(suspension(share=None), equality=True)

    def test_with_the_wheels_speed_measured_it_has_one(self) -> None:
        gains = design(suspension(share=None, wheel_speed=True), equality=True)
        assert gains.mismatch < 1e-6
        assert np.linalg.eigvalsh(gains.P).min() > 0.0
        assert gains.peak <= gains.beta

    def test_it_finds_the_stored_gains_again(self) -> None:
        gains = design(suspension(), noise=NOISE, fastest=200.0)
        np.testing.assert_allclose(gains.L, STORED.L, rtol=0.02, atol=0.1)
        np.testing.assert_allclose(gains.H[0], STORED.H[0], rtol=0.02, atol=1e-5)
        assert gains.beta == pytest.approx(STORED.beta, rel=1e-3)

    def test_noise_that_counts_more_gives_smaller_gains(self) -> None:
        sizes = [
            np.abs(design(suspension(), noise=w * NOISE, fastest=200.0).L).max()
            for w in (0.1, 1.0, 4.0)
        ]
        assert sizes[0] > 5.0 * sizes[1] > 25.0 * sizes[2]

    def test_what_is_kept_drives_the_observer(self, tmp_path: Path) -> None:
        path = tmp_path / 'gains.json'
        assert main(['--keep', str(path)]) == 0
        observer = HInfinityObserver('suspension', gains=str(path))
        np.testing.assert_allclose(observer.workspace.L, STORED.L, rtol=0.02, atol=0.1)

    def test_several_parameters_of_any_model_get_gains(self, tmp_path: Path) -> None:
        path = tmp_path / 'gains.json'
        told = ['--model', 'heat_exchanger_reduced', '--parameters', 'dP1', 'dP2']
        assert main([*told, '--fastest', '50', '--keep', str(path)]) == 0
        gains = read_gains(path, load_model('heat_exchanger_reduced'))
        assert gains.parameters == ('dP1', 'dP2')
        assert gains.L.shape == (4, 2) and gains.B.shape == (4, 2) and gains.H.shape == (2, 2)
        assert gains.peak <= gains.beta
