import numpy as np
import pytest
from ball_and_beam import made_up

from obs_ros import Sample
from obs_ros.interface.settings import build_observer
from obs_ros.replay.engine import replay
from obs_ros.replay.settings import setup

GIVEN = {'model': 'ball_and_beam:BALL', 'window.duration': 5.0, 'window.period': 2.5}
TRUTH = {'a': 5.0, 'b': 0.3, 'c': 0.1}
T, U, Y = made_up()


def samples(rows=300):
    for k in range(rows):
        yield Sample(round(T[k] * 1e9), u=U[k : k + 1])
        yield Sample(round(T[k] * 1e9), y=Y[k : k + 1])


def estimates(given, **options):
    taken = []
    account = replay(setup(given), samples(), take=lambda e, _: taken.append(e), **options)
    return account, taken


def test_it_is_the_observer_of_the_node_bit_by_bit():
    chosen = setup(GIVEN)
    observer = build_observer(chosen.model, chosen.values)
    alone = [observer.estimate() for sample in samples() if observer.absorb(sample)]
    _, taken = estimates(GIVEN)
    assert len(taken) == len(alone) == 10
    for one, other in zip(taken, alone):
        assert (one.parameters, one.state, one.stamp) == (
            other.parameters,
            other.state,
            other.stamp,
        )
        assert one.stddev == pytest.approx(other.stddev, rel=0, abs=0, nan_ok=True)
        assert one.message == other.message


def test_it_finds_the_truth_and_foretells_as_well_as_the_noise_allows():
    account, taken = estimates(GIVEN)
    for estimate in taken:
        assert estimate.parameters == pytest.approx(TRUTH, abs=0.05)
    history = account.history
    assert len(history) == 10
    assert account.horizon == 5.0
    # 2.4 s to the end of the recording are too short for the last two forecasts.
    foretold = history.rows('forecasts')[:, 0]
    assert np.isfinite(foretold).tolist() == [True] * 8 + [False] * 2
    assert np.median(foretold[:8]) < 1e-2 < np.median(history.rows('held')[:8, 0])
    assert np.median(history.rows('residuals')) == pytest.approx(1e-4, rel=0.2)
    assert account.recorded == pytest.approx(29.9)
    assert account.samples == 2 * len(T)
    assert account.counts['skipped'] == 0


def test_same_seed_same_bits():
    rows = []
    for seed in (0, 0, 1):
        account, _ = estimates({**GIVEN, 'seed': seed})
        rows.append([account.history.rows(k).tobytes() for k in ('values', 'deviations')])
    assert rows[0] == rows[1]
    assert rows[0] != rows[2]


def test_the_deadline_counts_only_when_told_so():
    account, _ = estimates({**GIVEN, 'deadline': 1e-9})
    assert 'deadline' not in account.history.outcomes
    account, _ = estimates({**GIVEN, 'deadline': 1e-9}, deadline=True)
    assert account.history.outcomes['deadline'] == 10


def test_an_immediate_observer_estimates_at_every_output():
    account, taken = estimates(
        {'model': 'ball_and_beam:BALL', 'observer': 'ekf', 'noise.y': 1e-4, 'initial.a': 3.0}
    )
    assert len(taken) == len(T)
    assert account.horizon is None
    assert taken[-1].parameters['a'] == pytest.approx(5.0, abs=0.2)
    assert np.isfinite(account.history.rows('rms')).sum() >= len(T) - 1


def test_a_break_of_the_timeline_is_told():
    def twice():
        yield from samples(100)
        yield from samples(100)

    account = replay(setup(GIVEN), twice())
    assert any('stamps jumped back' in note for note in account.notes)
    assert account.counts['reset'] == 1
    assert len(account.history) == 4


def test_an_observer_that_fails_does_not_end_the_replay(monkeypatch):
    from obs_ros.horizon.moving_horizon import MovingHorizon

    solve = MovingHorizon.solve

    def fails_once(self, record, rng, deadline):
        if record.t[0] == 0.0:
            raise FloatingPointError('on purpose')
        return solve(self, record, rng, deadline)

    monkeypatch.setattr(MovingHorizon, 'solve', fails_once)
    account, taken = estimates(GIVEN)
    assert account.failed == 1
    assert account.notes == ["failed at 5 s: FloatingPointError('on purpose')"]
    assert len(taken) == 9


def test_a_prior_counts_as_in_the_node():
    """One that is far off is contradicted, as long as no window has taken over from it."""
    _, taken = estimates({**GIVEN, 'prior.a': [3.0, 0.1], 'noise.r': 1e-4})
    assert taken[0].message.startswith('check the prior, or the model: a = ')
    _, plain = estimates({**GIVEN, 'noise.r': 1e-4})
    assert not any('contradicts' in estimate.message for estimate in plain)
