"""Tests of obs_ros.inference.assessment.identifiability."""

import re
from typing import Any

import numpy as np
import pytest
from plants import LAG, window_of

from obs_ros import Model, Record, Variable
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.identifiability import (
    advice,
    unseparated,
    weak_directions,
)
from obs_ros.inference.assessment.informed_subspace import marginal_information
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.prior import Prior

T = 0.1 * np.arange(61)
SIGMA = 0.01


def plant(rate: Any, count: int) -> Model:
    """x' = rate(p, u) - x with parameters p1 ... in (0, 4)."""
    return Model(
        name='combined',
        states=(Variable('x', lower=-10.0, upper=10.0),),
        inputs=(Variable('u'),),
        outputs=(Variable('y'),),
        parameters=[Variable(f'p{i + 1}', lower=0.0, upper=4.0) for i in range(count)],
        dynamics=lambda t, x, u, p: (rate(p, u[0]) - x[0],),
        output=lambda t, x, u, p: (x[0],),
        max_step=0.1,
    )


def said(rate: Any, *p: float, known: float = 1.0) -> tuple[str, ...]:
    """Words about a window in which the parameters have these values."""
    model = plant(rate, len(p))
    objective = window_of(model, Record(T, np.sin(T), np.zeros(61)), SIGMA)
    truth = {'x': 1.0, **{f'p{i + 1}': value for i, value in enumerate(p)}}
    z = objective.unknowns.point(truth)
    problem = PiecewiseProblem(objective, Prior.box(objective.unknowns))
    best = hypothesis_at(problem, z)
    covariance = known**2 * best.covariance[1:, 1:]
    return weak_directions(objective, z[1:], marginal_information(best, 1), covariance)


def test_all_determined() -> None:
    assert said(lambda p, u: p[0] + p[1] * u, 1.5, 1.0) == ()


def test_a_single_one() -> None:
    assert said(lambda p, u: p[0] + 0.0 * p[1], 1.5, 1.0) == ('p2 is not determined',)


@pytest.mark.parametrize(
    ('rate', 'words'),
    [
        (lambda p, u: p[0] * p[1], 'only p1*p2 is determined'),
        (lambda p, u: p[0] / p[1], 'only p1/p2 is determined'),
        (lambda p, u: p[0] / p[1] ** 2, 'only p1/p2^2 is determined'),
        (lambda p, u: p[1] * p[0] ** 2, 'only p2*p1^2 is determined'),
        (lambda p, u: p[0] * p[1] ** 3, 'only p1*p2^3 is determined'),
        (lambda p, u: p[0] * np.sqrt(p[1]), 'only p2*p1^2 is determined'),
        (lambda p, u: p[0] ** 2 / p[1] ** 3, 'only p1^2/p2^3 is determined'),
    ],
)
def test_power_products(rate: Any, words: str) -> None:
    found = said(rate, 1.5, 1.2)
    assert len(found) == 1
    a, b = (re.sub('only | is determined', '', text) for text in (found[0], words))
    # As good as equal: p1*p2^0.5 may be said as p1^2*p2.
    assert powers(a) == pytest.approx(powers(b)), found[0]


def powers(product: str) -> float:
    """Power of p2 for one of p1 in a product."""
    sign = -1.0 if '/' in product else 1.0
    power = dict(re.findall(r'(p\d)(?:\^(\d))?', product))
    return sign * float(power['p2'] or 1) / float(power['p1'] or 1)


def test_a_sum_has_no_product() -> None:
    """What leaves a sum alone is p1 +1 % and p2 -1.32 % here, near no small power."""
    (words,) = said(lambda p, u: p[0] + p[1], 3.3, 2.5)
    match = re.fullmatch(r'p1 \+(\S+) %, p2 -(\S+) % leave the outputs unchanged', words)
    assert match, words
    assert float(match[2]) / float(match[1]) == pytest.approx(1.32, abs=0.06)


def test_three_that_act_together() -> None:
    found = said(lambda p, u: (p[0] + p[1] * u) * p[2], 1.0, 1.0, 1.0)
    assert len(found) == 1
    parts = dict(re.findall(r'(p\d) ([+-]\S+) %', found[0]))
    shares = {name: float(value) for name, value in parts.items()}
    assert shares == pytest.approx({'p1': 1.0, 'p2': 1.0, 'p3': -1.0}, abs=0.06)


def test_two_weak_directions_are_both_named() -> None:
    found = said(lambda p, u: p[0] * p[1] + u / p[2] ** 2 * p[3], 1.5, 1.2, 1.0, 2.0)
    assert len(found) == 2
    assert {frozenset(re.findall(r'p\d', words)) for words in found} == {
        frozenset({'p1', 'p2'}), frozenset({'p3', 'p4'})
    }  # fmt: skip
    assert 'only p1*p2 is determined' in found or 'only p2*p1 is determined' in found
    assert any(words in found for words in ('only p4/p3^2 is determined',
                                            'only p3^2/p4 is determined'))  # fmt: skip
    found = said(lambda p, u: p[0] * p[1] + 0.0 * p[2], 1.5, 1.2, 1.0)
    assert 'p3 is not determined' in found
    assert any('p1' in words and 'p2' in words and 'only' in words for words in found)


def test_what_earlier_windows_know_is_said() -> None:
    (words,) = said(lambda p, u: p[0] * p[1], 1.5, 1.2, known=0.01)
    assert words.endswith(' is determined (known from earlier windows)')


def lag(nodes: int, u: Array, sigma: float = SIGMA, start: float = 0.5) -> Hypothesis:
    """A lag with k 2 and tau 15 s, known exactly."""
    t = 0.1 * np.arange(nodes)
    objective = window_of(LAG, Record(t, u, np.zeros(nodes)), sigma)
    z = objective.unknowns.point({'x': start, 'k': 2.0, 'tau': 15.0})
    return hypothesis_at(PiecewiseProblem(objective, Prior.box(objective.unknowns)), z)


def advised(best: Hypothesis, *chosen: int) -> str:
    objective = best.problem.objective
    return advice(objective, best.linearisation.state, np.array([2.0, 15.0]), np.array(chosen))


@pytest.mark.parametrize('sigma', [0.01, 0.03, 0.1])
def test_a_window_as_long_as_advised_determines(sigma: float) -> None:
    """And one of a quarter of that, less than half, does not."""
    nodes = 21
    short = lag(nodes, np.ones(nodes), sigma)
    deviations = np.sqrt(np.diagonal(short.covariance))
    assert deviations[2] > 0.1
    text = advised(short, 1, 2)
    match = re.match(r'a window of about (\S+) s would determine k and tau, even if', text)
    assert match, text
    length = float(match[1])
    assert length >= 2.0 * 2.0

    def deviation(seconds: float) -> float:
        count = round(10.0 * seconds) + 1
        return float(np.sqrt(np.diagonal(lag(count, np.ones(count), sigma).covariance))[1:].max())

    assert deviation(2.0 * length) < 0.1
    assert deviation(length / 4.0) > 0.1


def hopeless(*p: float) -> tuple[Any, ...]:
    """A window of x' = (p1 + p2) u - x at rest, what it says, and what no input tells apart."""
    model = plant(lambda p, u: (p[0] + p[1]) * u, 2)
    objective = window_of(model, Record(T, np.sin(T), np.zeros(61)), SIGMA)
    z = objective.unknowns.point({'x': 1.0, 'p1': p[0], 'p2': p[1]})
    best = hypothesis_at(PiecewiseProblem(objective, Prior.box(objective.unknowns)), z)
    return best, z, unseparated(objective)


@pytest.mark.parametrize('p', [(3.3, 2.5), (3.9, 0.1), (0.1, 3.9)])
def test_a_sum_that_no_input_tells_is_named_as_one(p: tuple[float, float]) -> None:
    best, z, structural = hopeless(*p)  # of unequal ones, relative changes leave one alone
    information = marginal_information(best, 1)
    words = weak_directions(
        best.problem.objective, z[1:], information, best.covariance[1:, 1:], structural
    )
    assert words == ('only p1 + p2 is determined',)


def test_no_input_is_asked_for_where_none_can_help() -> None:
    best, _, structural = hopeless(1.0, 1.0)
    objective, p = best.problem.objective, np.array([1.0, 1.0])
    words = advice(objective, best.linearisation.state, p, np.array([1, 2]), structural)
    assert words == 'no input can tell p1 from p2: fix one, or estimate their sum'


def test_where_no_window_would_do_moving_the_inputs_is_advised() -> None:
    nodes = 61
    at_rest = lag(nodes, np.zeros(nodes), start=0.0)
    assert advised(at_rest, 2) == (
        'move the inputs: while they stay as they are, no window up to 32 times as long would '
        'determine tau'
    )


def test_a_model_that_diverges_ahead_gives_no_advice() -> None:
    grows = Model(
        name='grows',
        states=(Variable('x', lower=0.0, upper=4.0),),
        outputs=(Variable('y'),),
        parameters=(Variable('p', lower=0.0, upper=1.0),),
        dynamics=lambda t, x, u, p: (p[0] * x[0] ** 2,),
        output=lambda t, x, u, p: (x[0],),
        max_step=0.01,
    )
    t = np.linspace(0.0, 0.5, 51)
    objective = window_of(grows, Record(t, None, t), SIGMA)
    assert advice(objective, np.array([2.0]), np.array([0.5]), np.array([1])) == ''


def tilted(ratio: float, sharp: float) -> tuple[str, ...]:
    """Words where p1 +`ratio` % and p2 +1 % are weakest, and what is across them is `sharp`."""
    objective = window_of(
        plant(lambda p, u: p[0] + p[1] * u, 2), Record(T, np.sin(T), np.zeros(61)), SIGMA
    )
    values = np.array([0.5, 0.5])
    along = np.array([ratio, 1.0]) / np.hypot(ratio, 1.0)
    across = np.array([-along[1], along[0]])
    information = 1e-3 * np.outer(along, along) + sharp * np.outer(across, across)
    return weak_directions(objective, values, information, np.eye(2))


def test_a_product_turned_by_noise_is_named_if_nothing_along_it_is_seen() -> None:
    """A tenth of the box along p1/p2^2 itself would show by 1.2 standard deviations, or 6."""
    assert tilted(1.87, 2e5) == ('only p1/p2^2 is determined',)
    (words,) = tilted(1.87, 5e6)
    assert words == 'p1 +1.9 %, p2 +1 % leave the outputs unchanged'
