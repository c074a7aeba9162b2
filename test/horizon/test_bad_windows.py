"""Whatever data and models are: no exception leaves the front doors, and no warning."""

from typing import Any

import numpy as np
import pytest
from plants import BLOW_UP, INTEGRATOR
from scipy.integrate import solve_ivp

from obs_ros import Model, Outcome, Record, Sample, Variable, solve_window
from obs_ros.core.deadline import Deadline
from obs_ros.core.linear_algebra import cholesky, eigen, inverted
from obs_ros.core.rng import random_generator
from obs_ros.core.typing import Array
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.observers.base import load_observer

pytestmark = pytest.mark.filterwarnings('error')

K = 30
T = 0.1 * np.arange(K)


def plant(name: str, dynamics: Any, output: Any, upper: float, outputs: int = 1) -> Model:
    return Model(
        name=name,
        states=(Variable('x', lower=-upper, upper=upper),),
        inputs=(Variable('u'),),
        outputs=tuple(Variable(f'y{i}') for i in range(outputs)),
        parameters=(Variable('a', lower=0.0, upper=300.0), Variable('idle', lower=0.0, upper=1.0)),
        dynamics=dynamics,
        output=output,
        max_step=0.1,
    )


PLANTS = (
    INTEGRATOR,
    BLOW_UP,
    plant('overflows', lambda t, x, u, p: (p[0] * x[0],), lambda t, x, u, p: (np.exp(x[0]),), 1e1),
    plant('huge', lambda t, x, u, p: (p[0] * x[0] ** 2,), lambda t, x, u, p: (x[0] ** 2,), 1e200),
    plant('twice', lambda t, x, u, p: (u[0] - x[0],), lambda t, x, u, p: (x[0], x[0]), 1e1, 2),
    plant('no_root', lambda t, x, u, p: (1.0 / (p[0] - 150.0),),
          lambda t, x, u, p: (np.sqrt(x[0] - 2.0),), 10.0),
)  # fmt: skip

QUICK = ('integrator', 'blow_up', 'no_root')  # the others' kernels take their time to compile
TRIED = [
    pytest.param(model, id=model.name, marks=[] if model.name in QUICK else [pytest.mark.slow])
    for model in PLANTS
]


def zoo(outputs: int) -> dict[str, Array]:
    rng = np.random.default_rng(1)
    sine = np.sin(T)[:, None] * np.ones(outputs)
    noise = rng.standard_normal((K, outputs))
    spike, once = sine + 0.01 * noise, np.full((K, outputs), np.nan)
    spike[K // 2], once[3] = 1e99, 0.5
    return {
        'sine': sine + 0.01 * noise,
        '1e99': 1e99 * sine,
        '1e200': 1e200 * (sine + noise),
        '1e308': 1.7e308 * np.sign(noise),
        'zeros': 0.0 * sine,
        'constant': 0.0 * sine + 7.0,
        'denormal': 5e-324 * np.sign(noise),
        'tiny': 1e-300 * noise,
        'spike': spike,
        'one sample': once,
    }


def noises(model: Model) -> list[Any]:
    return [None, *({v.name: sigma for v in model.outputs} for sigma in (0.01, 1e-300))]


@pytest.mark.parametrize('model', TRIED)
def test_solve_window_and_windows_say_it_as_an_outcome(model: Model, backend: Any) -> None:
    few = ('1e308', 'zeros', 'spike')  # for NumPy, which takes long
    for kind, y in zoo(len(model.outputs)).items():
        if backend == 'numpy' and kind not in few:
            continue
        record = Record(T, np.full((K, len(model.inputs)), 1e300 if kind == 'tiny' else 1.0), y)
        for noise in noises(model) if backend == 'numba' else noises(model)[:1]:
            estimate = solve_window(model, record, noise=noise, backend=backend)
            assert isinstance(estimate.outcome, Outcome), kind
            windows = MovingHorizon(
                Solver.of(model, EstimationSettings(noise=noise, backend=backend))
            )
            for i in range(2):
                windows.solve(record, random_generator(0, i), Deadline())
        if backend == 'numba':  # its plain twin takes long, and is compared with it elsewhere
            for noise in noises(model):
                found = solve_window(model, record, noise=noise, process_noise='auto')
                assert isinstance(found.outcome, Outcome), kind
        # Other searches ask the same of a backend: for NumPy one kind will do.
        for search in ('chaotic_de', 'ga') if backend == 'numba' or kind == few[0] else ():
            solve_window(model, record, search, backend=backend, search_options={'generations': 2})


@pytest.mark.parametrize('model', TRIED)
@pytest.mark.parametrize('name', ['ekf', 'ukf', 'sliding_window'])
def test_observers_go_on(model: Model, name: str) -> None:
    settings = {'duration': 2.0, 'period': 0.5} if name == 'sliding_window' else {}
    noise = {v.name: 0.01 for v in model.outputs}
    for y in zoo(len(model.outputs)).values():
        observer: Any = load_observer(name)(model, noise=noise, **settings)
        for k in range(K):
            if model.inputs:
                observer.absorb(Sample(100_000_000 * k, u=np.ones(len(model.inputs))))
            observer.absorb(Sample(100_000_000 * k, y=y[k]))
            observer.estimate()


def kinetics(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Robertson's."""
    a, b, c = x
    return -p[0] * a + p[2] * b * c, p[0] * a - p[2] * b * c - p[1] * b * b, p[1] * b * b


ROBERTSON = Model(
    name='robertson',
    states=(Variable('a', lower=0.0, upper=1.0), Variable('b', lower=0.0, upper=1e-3),
            Variable('c', lower=0.0, upper=1.0)),
    outputs=(Variable('a'), Variable('b'), Variable('c')),
    parameters=(Variable('k1', lower=1e-3, upper=1.0), Variable('k2', lower=1e6, upper=1e8),
                Variable('k3', lower=1e3, upper=1e5)),
    dynamics=kinetics,
    output=lambda t, x, u, p: x,
    max_step=1e-3,
)  # fmt: skip


@pytest.mark.parametrize('noise', [None, {'a': 1e-3, 'b': 1e-8, 'c': 1e-3}])
def test_a_stiff_plant_has_an_outcome(noise: Any) -> None:
    """Of time constants of 1 ms and less, beside 25 s, and of outputs of 1 beside 1e-5."""
    pytest.importorskip('numba')
    t = np.linspace(0.0, 0.3, 40)
    y = solve_ivp(
        lambda s, x: kinetics(s, x, (), (0.04, 3e7, 1e4)), (0.0, 0.3), [1.0, 0.0, 0.0],
        method='BDF', t_eval=t, rtol=1e-8, atol=1e-12,
    ).y.T  # fmt: skip
    y = y + np.array([1e-3, 1e-8, 1e-3]) * np.random.default_rng(0).standard_normal(y.shape)
    estimate = solve_window(ROBERTSON, Record(t, np.zeros((40, 0)), y), noise=noise)
    assert isinstance(estimate.outcome, Outcome)


@pytest.mark.parametrize('matrix', [np.full((2, 2), np.nan), np.full((2, 2), np.inf)])
def test_what_has_no_answer_is_nan(matrix: Array) -> None:
    values, vectors = eigen(matrix)
    assert np.isnan(values).all() and np.isnan(vectors).all()
    assert not np.isfinite(inverted(matrix)).all()
    assert np.isnan(inverted(np.zeros((2, 2)))).all()
    assert np.isnan(cholesky(-np.eye(2))).all()


def test_what_has_one_is_that_of_numpy() -> None:
    matrix = np.array([[2.0, 1.0], [1.0, 3.0]])
    np.testing.assert_array_equal(eigen(matrix)[0], np.linalg.eigh(matrix)[0])
    np.testing.assert_array_equal(inverted(matrix), np.linalg.inv(matrix))
    np.testing.assert_array_equal(cholesky(matrix), np.linalg.cholesky(matrix))
