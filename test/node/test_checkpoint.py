"""What a node has learned survives its restart."""

import os
from pathlib import Path

import pytest
from node.fakes import FakeObserver
from plants import tank_outputs
from ros import Ros, figures, set_parameter, vector
from std_srvs.srv import Trigger

from obs_ros.core.record import Sample
from obs_ros.interface.checkpoint_file import decode, read
from obs_ros.observers.sliding_window import SlidingWindowObserver
from obs_ros.ros.estimator import Estimator

FAKE = 'node.fakes:RememberingFake'
LEVELS, FEEDS = ('h1', 'h2'), ('Q1', 'Q2')
FEED = (30.0, 30.0)


def ready(ros: Ros, **parameters):
    estimator = ros.start(Estimator, **parameters)
    ros.spin_until(lambda: estimator.estimation.progress.ready and estimator.estimation.idle, 60.0)
    return estimator


def faked(ros: Ros, path: Path, **parameters):
    return ready(ros, checkpoint=str(path), observer=FAKE, window__duration=2.0, **parameters)


def spoken(ros: Ros, *times: float, levels=lambda t: (t, t)) -> None:
    """Send samples by publishers of their own, so that none is of a node that is gone."""
    output, feed = ros.speak('/plant/output'), ros.speak('/plant/input')
    for t in times:
        feed(t, FEEDS, FEED)
        output(t, LEVELS, levels(t))


def written(ros: Ros, path: Path, seen: int) -> None:
    def found():
        return path.exists() and decode(read(path))['memory'] == {'outputs': seen}

    ros.spin_until(found)


def resumed(ros: Ros, path: Path) -> Estimator:
    """Return the second of two estimators, which takes up what the first has written."""
    first = faked(ros, path)
    spoken(ros, 1.0, 2.0)
    written(ros, path, 2)
    ros.stop(first)
    return faked(ros, path)


def test_the_first_estimate_after_a_restart_is_that_of_a_run_that_never_stopped(
    ros: Ros, tmp_path: Path
) -> None:
    levels = tank_outputs([float(t) for t in range(100)], (50.0, 40.0, 45.0), (0.6, 0.5, 0.7))
    settings = {
        'checkpoint': str(tmp_path / 'tank'), 'window__duration': 30.0, 'deadline': 600.0,
        'noise__h1': 0.01, 'noise__h2': 0.01,
    }  # fmt: skip
    whole = SlidingWindowObserver(
        'three_tank', duration=30.0, noise={'h1': 0.01, 'h2': 0.01}, capacity=100000
    )
    stream = [Sample(t * 10**9, y=levels[t], u=[30.0, 30.0]) for t in range(62)]
    expected = [whole.estimate() for sample in stream if whole.absorb(sample)]
    estimator = ready(ros, **settings)
    spoken(ros, *range(31), levels=lambda t: levels[t])
    ros.spin_until(lambda: estimator.estimation.progress.published == 1, 60.0)
    ros.spin_until(lambda: estimator.estimation.idle)
    ros.stop(estimator)
    estimator = ready(ros, **settings)
    heard = ros.listen('/estimator/parameters')
    assert figures(ros.health())['checkpoint'] == 'taken up'
    spoken(ros, *range(31, 61), levels=lambda t: levels[t])
    ros.spin_until(lambda: heard, 60.0)
    assert len(expected) == 2
    assert vector(heard[0]) == expected[1].parameters
    found = estimator.estimation.progress.estimate.stddev
    assert found == pytest.approx(expected[1].stddev, rel=0, abs=0, nan_ok=True)


def test_a_node_without_a_file_or_with_one_that_is_damaged_begins_anew_and_says_so(
    ros: Ros, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / 'tank'
    first = faked(ros, path)
    assert figures(ros.health())['checkpoint'] == 'begun without: there was no file yet'
    spoken(ros, 1.0, 2.0)
    written(ros, path, 2)
    ros.stop(first)
    path.write_bytes(path.read_bytes()[:-3])
    second = faked(ros, path)
    told = figures(ros.health())['checkpoint']
    assert told.startswith('begun anew: it is damaged: ') and told.endswith(f'{path}.refused')
    assert f'checkpoint {path}: begun anew: it is damaged: ' in capfd.readouterr().err
    assert second.estimation.observer.before == 0
    spoken(ros, 3.0, 4.0)
    written(ros, path, 2)


def test_what_cannot_be_written_is_counted_and_told_and_the_node_goes_on(
    ros: Ros, tmp_path: Path
) -> None:
    folder = tmp_path / 'gone'
    folder.mkdir()
    estimator = faked(ros, folder / 'tank')
    for each in folder.iterdir():
        each.unlink()
    folder.rmdir()
    spoken(ros, 1.0, 2.0)
    ros.spin_until(lambda: estimator.estimation.progress.published == 1)
    ros.spin_until(lambda: estimator.estimation._checkpoint.account.failed)
    health = ros.spin_until(lambda: ros.health(outcome='converged'))
    assert 'FileNotFoundError' in figures(health)['checkpoint.error']
    assert figures(health)['checkpoint.failed'] == '1'
    assert health.level == b'\x01'
    assert f'look at the disk and rights of {folder}/tank: ' in health.message
    assert health.message.endswith('converged: as told')
    folder.mkdir()
    spoken(ros, 3.0, 4.0)
    written(ros, folder / 'tank', 4)
    assert 'look at the disk' not in ros.health(outcome='converged').message


def test_a_reset_forgets_the_file_as_well(ros: Ros, tmp_path: Path) -> None:
    path = tmp_path / 'tank'
    estimator = faked(ros, path)
    spoken(ros, 1.0, 2.0)
    written(ros, path, 2)
    assert ros.call('/estimator/reset', Trigger).success
    ros.spin_until(lambda: not path.exists())
    assert figures(ros.health())['checkpoint'] == 'begun anew: asked to'
    ros.stop(estimator)
    assert not path.exists()


def test_stamps_that_jump_back_forget_it_too(ros: Ros, tmp_path: Path) -> None:
    path = tmp_path / 'tank'
    faked(ros, path)
    spoken(ros, 10.0, 11.0)
    written(ros, path, 2)
    spoken(ros, 3.0)
    ros.spin_until(lambda: not path.exists())
    assert figures(ros.health())['checkpoint'].startswith('begun anew: stamps jumped back to')


def test_a_memory_that_no_window_can_be_solved_with_is_gone_at_the_next_start(
    ros: Ros, tmp_path: Path
) -> None:
    path = tmp_path / 'tank'
    second = resumed(ros, path)
    assert second.estimation.observer.before == 2
    FakeObserver.made[-1].value = ZeroDivisionError('of the memory')
    spoken(ros, 3.0, 4.0)
    ros.spin_until(lambda: second.estimation.progress.failed)
    ros.spin_until(lambda: not path.exists())
    assert second.estimation.observer.before == 0 and second.estimation.observer.resets == 1


def test_an_observer_for_changed_parameters_has_taken_nothing_up(ros: Ros, tmp_path: Path) -> None:
    path = tmp_path / 'tank'
    second = resumed(ros, path)
    assert figures(ros.health())['checkpoint'] == 'taken up'
    assert set_parameter(second, 'bounds.h3', [1.0, 50.0]).successful
    ros.spin_until(lambda: figures(ros.health())['checkpoint'] == 'begun anew: parameters changed')
    # Its failures are not those of the file.
    ros.spin_until(lambda: second.estimation.progress.ready and second.estimation.idle)
    FakeObserver.made[-1].value = ZeroDivisionError('of the new one')
    spoken(ros, 3.0, 4.0)
    ros.spin_until(lambda: second.estimation.progress.failed)
    assert path.exists() and second.estimation.observer.resets == 0


def test_an_observer_that_remembers_nothing_is_refused_at_the_start(
    ros: Ros, tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match='leave checkpoint empty, or take observer'):
        ros.start(Estimator, checkpoint=str(tmp_path / 'tank'), observer='ekf')
    with pytest.raises(ValueError, match='make the folder first'):
        ros.start(Estimator, checkpoint=str(tmp_path / 'none' / 'tank'))
    assert os.listdir(tmp_path) == []


def test_nobody_moves_the_file_while_the_node_runs(ros: Ros, tmp_path: Path) -> None:
    estimator = faked(ros, tmp_path / 'tank')
    answer = set_parameter(estimator, 'checkpoint', '/etc/passwd')
    assert not answer.successful and 'read-only' in answer.reason
