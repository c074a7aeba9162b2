"""Tests of the extended and the unscented Kalman filter: closed form, consistency, bounds."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from arx import ARX, A, B, course, kalman_filter, pushes, samples
from plants import LAG, NAN, OSCILLATOR, observer_form, rich_input, trajectory
from scipy.linalg import expm
from scipy.stats import chi2
from spinner import SHAFT, TURN, UNWRAPPED, window

from obs_ros import Model, Sample, Variable
from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.core.typing import Array
from obs_ros.models.three_tank import THREE_TANK
from obs_ros.observers.kalman_filters.ekf import ExtendedKalmanObserver
from obs_ros.observers.kalman_filters.joint import limit, root
from obs_ros.observers.kalman_filters.ukf import UnscentedKalmanObserver

FILTERS = [ExtendedKalmanObserver, UnscentedKalmanObserver]
T = 0.01
TRUTH = (2.1, 2.1, 1.0, 1.0, 0.9, 0.8)
UNSTABLE = (-0.3, 2.1, 1.0, 1.0, 0.9, 0.8)


def form_matrix(p: Any) -> Array:
    return np.array([[-p[0], 1.0, 0.0], [-p[1], 0.0, 1.0], [-p[2], 0.0, 0.0]])


@pytest.mark.parametrize('p', [TRUTH, UNSTABLE])
@pytest.mark.parametrize('kind', FILTERS)
def test_on_a_linear_plant_it_is_the_kalman_filter(kind: Any, p: Any) -> None:
    """Known parameters, one output missing now and then: mean and covariance within 1e-9."""
    names = ('a2', 'a1', 'a0', 'b2', 'b1', 'b0')
    ranges = {name: (value - 1.0, value + 1.0) for name, value in zip(names, p)}
    model = replace(
        observer_form(**ranges),
        outputs=(Variable('y'), Variable('z')),
        output=lambda t, x, u, p: (x[0], x[0] + 2.0 * x[2]),
        inputs=(Variable('u'),),
        max_step=1e-3,
    )
    observer = kind(
        model, fixed=dict(zip(names, p)), noise={'y': 0.1, 'z': 0.5}, initial={'x2': 1.0},
        initial_state=0.01, state_walk=0.002, innovation_gate=0.0,
    )  # fmt: skip
    # The same by matrices. RK4 at 1 ms is exact to 1e-13 here.
    ab = np.zeros((4, 4))
    ab[:3, :3], ab[:3, 3] = form_matrix(p), p[3:]
    step = expm(ab * T)
    f, g = step[:3, :3], step[:3, 3]
    h, r = np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 2.0]]), np.diag([0.01, 0.25])
    x, c, held = np.array([0.0, 1.0, 0.0]), np.eye(3), 0.0
    rng = np.random.default_rng(4)
    for k in range(300):
        u, y = rng.normal(), rng.normal(size=2)
        if k % 5 == 2:
            y[k % 2] = NAN
        if k:
            x, c = f @ x + g * held, f @ c @ f.T + 0.04 * T * np.eye(3)
        seen = ~np.isnan(y)
        hs, innovation = h[seen], (y - h @ x)[seen]
        spread = hs @ c @ hs.T + r[np.ix_(seen, seen)]
        gain = c @ hs.T @ np.linalg.inv(spread)
        x, c = x + gain @ innovation, c - gain @ hs @ c
        observer.absorb(Sample(round(k * T * 1e9), u=np.array([u]), y=y))
        np.testing.assert_allclose(observer.innovation[seen], innovation, atol=1e-9)
        deviations = list(observer.estimate().innovation_stddev.values())
        np.testing.assert_allclose(np.array(deviations)[seen], np.sqrt(np.diagonal(spread)))
        assert np.isnan(np.array(deviations)[~seen]).all()
        np.testing.assert_allclose(observer.x, x, atol=1e-9)
        np.testing.assert_allclose(observer.joint.covariance[:3, :3], c, atol=1e-9)
        held = u
    assert not any(observer.counts[reason] for reason in ('reset_covariance', 'all_nan'))


@pytest.mark.parametrize('kind', FILTERS)
def test_errors_are_as_large_as_the_filter_says(kind: Any) -> None:
    """NEES of the oscillator's states and stiffness over 40 runs, seeds 0 to 39.

    The mean of 40 x 3 squared normalised errors must lie within the 99.9 % bounds of chi-square;
    that of 4040 normalised innovations, whose standard error is 0.016, between 0.93 and 1.07.
    """
    t = 0.05 * np.arange(101)
    sd, walk = np.array([0.3, 0.3, 0.09]), np.array([0.03, 0.03])
    nees, innovations = [], []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        start = np.array([1.0, -0.5, 1.0])
        truth = start + sd * rng.standard_normal(3)
        p, x = (truth[2], 0.5), truth[:2]
        observer = kind(
            OSCILLATOR, fixed={'push': 0.5}, noise={'y1': 0.02, 'y2': 0.05},
            initial={'position': 1.0, 'velocity': -0.5, 'stiffness': 1.0},
            initial_state=0.05, initial_parameter=0.05, state_walk=0.005, parameter_walk=0.0,
        )  # fmt: skip
        for k, now in enumerate(t):
            if k:
                x = trajectory(OSCILLATOR, t[k - 1 : k + 1], lambda s: (0.4,), x, p)[-1]
                x = x + np.sqrt(0.05) * walk * rng.standard_normal(2)
            y = np.array(OSCILLATOR.output(now, tuple(x), (0.4,), p))
            y = y + np.array([0.02, 0.05]) * rng.standard_normal(2)
            observer.absorb(Sample(round(now * 1e9), u=np.array([0.4]), y=y))
            innovations.append(observer.figures['normalised_innovation'])
        error = np.append(x, truth[2]) - observer.joint.z
        nees.append(error @ np.linalg.solve(observer.joint.covariance, error))
    low, high = chi2.ppf([0.0005, 0.9995], 40 * 3)
    assert low < sum(nees) < high
    assert 0.93 < np.mean(innovations) < 1.07


@pytest.mark.parametrize('kind', FILTERS)
def test_joint_states_and_parameters_of_the_third_order_plant(kind: Any) -> None:
    """Sums of squared errors of x2 and x3 over 100 s, as in Gremling & Passino 2000, Table 1.

    Noises r 1e-4, qx 1e-5 and qtheta 1e-8 a sample. Fixed mid-range parameters make 269 / 283.
    """
    model = observer_form()
    t = T * np.arange(10001)
    x = trajectory(model, t, lambda s: (rich_input(s),), (0.0, 0.0, 0.0), TRUTH)
    observer = kind(
        model, noise={'y': 1e-2}, initial_state=1e-3, initial_parameter=0.3,
        state_walk=np.sqrt(1e-5 / T) / 100.0, parameter_walk=np.sqrt(1e-8 / T) / 0.45,
    )  # fmt: skip
    sums = np.zeros(3)
    for k, now in enumerate(t):
        observer.absorb(Sample(round(now * 1e9), u=np.array([rich_input(now)]), y=x[k, :1]))
        sums += (observer.x - x[k]) ** 2
    assert sums[1] < 66.0 and sums[2] < 141.0
    assert not observer.counts['reset_covariance']


@pytest.mark.parametrize('kind', FILTERS)
def test_estimates_stay_within_bounds_and_the_model_never_sees_others(kind: Any) -> None:
    """A root of what must not be negative, measured below zero: no NaN, no restart."""
    seen = []

    def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
        if not np.isscalar(x[0]):
            seen.append(np.min(x[0]))
        return (-p[0] * np.sqrt(x[0]),)

    model = Model(
        name='draining',
        states=(Variable('level', lower=0.0, upper=4.0),),
        outputs=(Variable('level'),),
        parameters=(Variable('drain', lower=0.1, upper=1.0),),
        dynamics=dynamics,
        output=lambda t, x, u, p: (x[0],),
        max_step=0.05,
        integrator='euler',
    )
    observer = kind(model, noise={'level': 0.1}, backend='numpy')
    rng = np.random.default_rng(1)
    for k in range(200):
        level = max(0.0, 2.0 - 0.05 * 0.3 * k) ** 2 / 2.0
        observer.absorb(Sample(k * 50_000_000, y=np.array([level + 0.1 * rng.standard_normal()])))
        estimate = observer.estimate()
        assert 0.0 <= estimate.state['level'] <= 4.0
        assert 0.1 <= estimate.parameters['drain'] <= 1.0
    assert min(seen) >= 0.0
    assert not observer.counts['reset_non_finite'] and not observer.counts['reset_covariance']


@pytest.mark.parametrize('kind', FILTERS)
@pytest.mark.parametrize(('bound', 'beyond'), [('lower', -2.0), ('upper', 6.0)])
def test_an_estimate_stops_at_the_bound_that_the_outputs_drive_it_through(
    kind: Any, bound: str, beyond: float
) -> None:
    """A level in [0, 4] that is measured outside, the sum of two: both stop at the bound."""
    names = ('one', 'other')
    model = Model(
        name='held',
        states=tuple(Variable(name, lower=0.0, upper=4.0) for name in names),
        outputs=(Variable('y'), Variable('sum')),
        parameters=(Variable('rate', lower=-1.0, upper=1.0),),
        dynamics=lambda t, x, u, p: (0.0 * p[0], 0.0 * p[0]),
        output=lambda t, x, u, p: (x[0], x[0] + x[1]),
        max_step=1.0,
    )
    observer = kind(model, noise={'y': 0.01, 'sum': 0.01}, backend='numpy', innovation_gate=0.0)
    for k in range(5):
        observer.absorb(Sample(k * 10**9, y=np.array([beyond, 2.0 * beyond])))
        estimate = observer.estimate()
        assert [estimate.state[name] for name in names] == [getattr(model.states[0], bound)] * 2


@pytest.mark.parametrize('kind', FILTERS)
def test_no_variance_grows_beyond_that_of_the_box(kind: Any) -> None:
    """States that wander by most of their box in a second, and outputs that tell nearly nothing."""
    model = Model(
        name='drift',
        states=(Variable('a', lower=0.0, upper=2.0), Variable('b', lower=0.0, upper=4.0)),
        outputs=(Variable('seen'),),
        parameters=(Variable('speed', lower=-1.0, upper=1.0),),
        dynamics=lambda t, x, u, p: (p[0] + 0.0 * x[0], 2.0 * p[0] + 0.0 * x[0]),
        output=lambda t, x, u, p: (x[0],),
        max_step=1.0,
    )
    observer = kind(
        model, noise={'seen': 1e3}, backend='numpy', state_walk=0.95, parameter_walk=0.0
    )
    for k in range(10):
        observer.absorb(Sample(k * 10**9, y=np.array([1.0])))
        assert (np.linalg.eigvalsh(observer.joint.covariance) > 0.0).all()
    deviations = np.sqrt(np.diag(observer.joint.covariance))
    assert deviations[:2] == pytest.approx([2.0, 4.0])  # the widths of the box
    assert not observer.counts['reset_covariance']


def test_a_variance_is_capped_with_its_correlations_kept() -> None:
    half = np.random.default_rng(3).standard_normal((3, 3))
    before = half @ half.T
    after, most = before.copy(), np.array([np.inf, 0.25 * before[1, 1], 4.0 * before[2, 2]])
    limit(after, most)
    assert np.diag(after) == pytest.approx(np.diag(before) * [1.0, 0.25, 1.0])

    def correlations(c: Array) -> Array:
        return c / np.sqrt(np.outer(np.diag(c), np.diag(c)))

    np.testing.assert_allclose(correlations(after), correlations(before), rtol=1e-12)


@pytest.mark.parametrize('kind', FILTERS)
def test_a_covariance_that_is_none_any_more_starts_again(kind: Any) -> None:
    observer = kind(THREE_TANK, noise={'h1': 0.1, 'h2': 0.1})
    feed, levels = np.array([30.0, 30.0]), np.array([50.0, 40.0])
    observer.absorb(Sample(0, u=feed, y=levels))
    # As rounding might: one filter goes on from the covariance, one from weighted sigma points.
    spoilt = (
        observer.joint.covariance
        if kind is ExtendedKalmanObserver
        else observer.workspace.weights[2:3]
    )
    kept = spoilt.copy()
    spoilt[:] = -100.0 * kept
    observer.absorb(Sample(10**9, u=feed, y=levels))
    if kind is UnscentedKalmanObserver:
        spoilt[:] = kept
    estimate = observer.estimate()
    restarts = observer.counts['reset_covariance']
    assert restarts == (1 if kind is ExtendedKalmanObserver else 2)  # predicting and correcting
    assert 'covariance started again at 1 s' in estimate.message
    assert estimate.usable
    assert np.isfinite(observer.joint.z).all()
    for k in range(2, 20):
        observer.absorb(Sample(k * 10**9, u=feed, y=levels))
    assert np.linalg.eigvalsh(observer.joint.covariance).min() > 0.0
    assert observer.counts['reset_covariance'] == restarts


@pytest.mark.parametrize('kind', FILTERS)
def test_what_is_not_estimated_stays_and_is_as_sure_as_it_is_given(kind: Any) -> None:
    observer = kind(THREE_TANK, parameters=['p2'], fixed={'p1': 0.6, 'p3': 0.7})
    feed = np.array([30.0, 30.0])
    for k in range(10):
        observer.absorb(Sample(k * 10**9, u=feed, y=np.array([50.0, 40.0])))
    estimate = observer.estimate()
    assert (estimate.parameters['p1'], estimate.parameters['p3']) == (0.6, 0.7)
    assert estimate.stddev['p1'] == estimate.stddev['p3'] == 0.0
    assert estimate.interval['p1'] == (0.6, 0.6) and estimate.interval['p3'] == (0.7, 0.7)
    assert 0.0 < estimate.stddev['p2'] < 0.3 and 0.0 < estimate.stddev['h3'] < 30.0


def test_roots_of_covariances_regular_singular_and_none() -> None:
    rng = np.random.default_rng(0)
    half = rng.standard_normal((4, 4))
    lower = np.empty((4, 4))
    assert root(half @ half.T, lower)
    np.testing.assert_allclose(lower, np.linalg.cholesky(half @ half.T), atol=1e-12)
    thin = rng.standard_normal((4, 2))
    assert root(thin @ thin.T, lower)
    np.testing.assert_allclose(lower @ lower.T, thin @ thin.T, atol=1e-6)
    for wrong in (np.diag([1.0, -1e-3, 1.0, 1.0]), np.diag([1.0, NAN, 1.0, 1.0]),
                  np.diag([np.inf, 1.0, 1.0, 1.0]), np.ones((4, 4)) - 0.1 * np.eye(4)):  # fmt: skip
        assert not root(wrong, lower)


@pytest.mark.parametrize('kind', FILTERS)
def test_a_prior_is_the_start_and_a_walk_the_noise(kind: Any) -> None:
    """Against the scalar Kalman filter of x' = -x / tau + ..., tau known: a walk of k alone."""
    walks, priors = {'x': 0.3}, {'x': (1.5, 0.4)}
    observer = kind(
        LAG, fixed={'k': 1.0, 'tau': 5.0}, noise={'y': 0.2}, walks=walks, priors=priors,
        state_walk=99.0, initial_state=99.0, innovation_gate=0.0,
    )  # fmt: skip
    decay, x, c = np.exp(-0.1 / 5.0), 1.5, 0.16
    rng = np.random.default_rng(2)
    for k in range(50):
        y = rng.standard_normal()
        if k:
            x, c = decay * x, decay**2 * c + 0.09 * 0.1
        gain = c / (c + 0.04)
        x, c = x + gain * (y - x), (1.0 - gain) * c
        observer.absorb(Sample(k * 10**8, u=np.zeros(1), y=np.array([y])))
        estimate = observer.estimate()
        assert estimate.state['x'] == pytest.approx(x, abs=1e-6)
        assert estimate.stddev['x'] == pytest.approx(np.sqrt(c), rel=1e-6)


@pytest.mark.parametrize('kind', FILTERS)
def test_a_model_brings_its_own_and_a_name_takes_their_place(kind: Any) -> None:
    model = with_knowledge(LAG, {'k': 0.1}, {'k': (2.0, 0.3)})
    assert kind(model).initial[1] == 2.0 and kind(model).joint.walk[1] == pytest.approx(0.01)
    other = kind(model, walks={'k': 0.2}, priors={'k': (3.0, 0.1)}, initial={'tau': 7.0})
    assert other.initial.tolist() == [0.0, 3.0, 7.0]
    assert other.joint.walk[1] == pytest.approx(0.04)
    assert kind(model, initial={'k': 2.5}).initial[1] == 2.5  # said outright
    none = kind(model, walks={'k': 0.0}, priors={'k': None})
    assert none.initial[1] == 1.0  # nominal
    assert none.joint.walk[1] == pytest.approx((1e-3 * 4.8) ** 2)
    with pytest.raises(ValueError, match='k cannot have a prior: it is not estimated'):
        kind(model, fixed={'k': 2.0}, priors={'k': (2.0, 0.1)})
    with pytest.raises(ValueError, match="no state or parameter 'kk': did you mean 'k'"):
        kind(model, walks={'kk': 0.1})


@pytest.mark.parametrize('kind', FILTERS)
def test_a_walk_of_the_logarithm_grows_with_the_value(kind: Any) -> None:
    """Nothing is measured of k while the input rests: its variance grows by (walk k)^2 dt."""
    parameters = (replace(LAG.parameters[0], scale='log'), LAG.parameters[1])
    model = replace(LAG, parameters=parameters)
    found = []
    for mean in (1.0, 4.0):
        observer = kind(
            model, fixed={'tau': 5.0}, initial={'x': 0.0}, noise={'y': 0.2},
            walks={'k': 0.02}, priors={'k': (mean, 0.01)},
        )  # fmt: skip
        noise = 0.2 * np.random.default_rng(5).standard_normal(101)
        for k, y in enumerate(noise):
            observer.absorb(Sample(k * 10**8, u=np.zeros(1), y=np.array([y])))
        found.append(observer.estimate().stddev['k'] ** 2 - 1e-4)
    np.testing.assert_allclose(found, [0.02**2 * 10.0, 0.08**2 * 10.0], rtol=1e-6)


@pytest.mark.parametrize('kind', FILTERS)
def test_a_prior_of_one_factor_makes_the_other_known(kind: Any) -> None:
    """Only k tau' is seen: the deviation of the other factor is that of the prior, in its share."""
    product = replace(
        LAG,
        name='product',
        dynamics=lambda t, x, u, p: (p[0] * p[1] * u[0] - x[0],),
        parameters=(Variable('a', lower=0.1, upper=10.0), Variable('b', lower=0.1, upper=10.0)),
    )
    observer = kind(
        product, noise={'y': 0.01}, initial={'a': 2.2}, priors={'b': (3.0, 0.03)},
        initial_parameter=0.1, parameter_walk=0.0, state_walk=0.0,
    )  # fmt: skip
    u, x, decay = 1.0, 0.5, np.exp(-0.1)
    rng = np.random.default_rng(3)
    for k in range(600):
        if k:
            x = decay * x + (1.0 - decay) * 6.0 * u
        u = 1.0 if (k // 20) % 2 else -1.0
        y = x + 0.01 * rng.standard_normal()
        observer.absorb(Sample(k * 10**8, u=np.array([u]), y=np.array([y])))
    estimate = observer.estimate()
    assert estimate.stddev['b'] == pytest.approx(0.03, rel=0.05)
    assert estimate.stddev['a'] == pytest.approx(0.02, rel=0.05)
    assert abs(estimate.parameters['a'] - 2.0) < 0.06


@pytest.mark.parametrize('kind', FILTERS)
def test_a_discrete_model_is_filtered_from_node_to_node(kind: Any) -> None:
    """Outputs at every third node, with jitter, one between nodes: noise enters at each node."""
    u = pushes(90)
    y = course(u, walk=0.5, noise=0.02)[1]
    y[np.arange(90) % 3 > 0] = NAN
    offsets = np.random.default_rng(3).uniform(-0.02, 0.02, 90)
    offsets[51] = 0.4
    observer = kind(
        ARX, fixed={'a1': A[0], 'a2': A[1], 'b': B}, noise={'y': 0.02},
        initial={'now': 0.8, 'last': 0.6}, initial_state=0.05, innovation_gate=0.0,
        walks={'now': 0.5, 'last': 0.1},
    )  # fmt: skip
    for sample in samples(u, y, offsets):
        observer.absorb(sample)
    u[51], y[51] = u[50], NAN  # the input acts from the next node on, where it is superseded
    expected = kalman_filter(u, y, [0.8, 0.6], np.eye(2), [0.5, 0.1], 0.02)
    np.testing.assert_allclose(observer.x, expected.means[87], rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(
        observer.joint.covariance[:2, :2], expected.covariances[87], rtol=1e-5, atol=1e-10
    )
    assert observer.counts['off_grid'] == 2
    assert observer.estimate().stamp == pytest.approx(87 * 10**8, abs=5 * 10**6)


@pytest.mark.parametrize('scene', [
    {'angle': 2.8}, {'angle': np.pi, 'swing': 0.2, 'noise': 0.1}, {'rate': 20.0, 'torque': 2.0},
], ids=['crossing', 'hovering', 'many turns'])  # fmt: skip
@pytest.mark.parametrize('kind', FILTERS)
def test_an_angle_that_wraps_is_filtered_as_one_that_does_not(kind: Any, scene: Any) -> None:
    """The same arithmetic but for whole turns, where both are told the same of start and walk.

    Boxes, from which they come else, are a turn wide here and 200 rad there.
    """
    wrapped, plain, states = window(nodes=101, **scene)
    settings = {
        'noise': {'angle': scene.get('noise', 0.02), 'tenth': 0.1},
        'priors': {'angle': (wrapped.y[0, 0], 0.3), 'rate': (scene.get('rate', 0.0), 2.0)},
        'walks': {'angle': 1e-3, 'rate': 1e-2},
    }
    errors, deviations = [], []
    for model, record in ((SHAFT, wrapped), (UNWRAPPED, plain)):
        observer = kind(model, **settings)
        found = []
        for t, u, y in zip(record.t, record.u, record.y):
            observer.absorb(Sample(round(t * 1e9), y=y, u=u))
            found.append(observer.estimate())
        off = np.array([one.state['angle'] for one in found]) - states[:, 0]
        errors.append(np.column_stack([
            off - TURN * np.round(off / TURN), [one.state['rate'] for one in found],
            [[*one.parameters.values()] for one in found],
        ]))  # fmt: skip
        deviations.append([[*one.stddev.values()] for one in found])
    assert (np.abs(np.diff(wrapped.y[:, 0])) > np.pi).any()
    np.testing.assert_allclose(*deviations, rtol=1e-6)
    assert (np.abs(errors[0] - errors[1]) < 1e-6 * np.array(deviations[1])).all()
    mean_squares = [np.mean(one[50:, 0] ** 2) for one in errors]
    assert mean_squares[0] == pytest.approx(mean_squares[1], rel=1e-6)
