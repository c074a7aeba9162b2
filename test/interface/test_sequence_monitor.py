import pytest

from obs_ros.interface.sequence_monitor import SequenceMonitor, SequenceSettings

LIMITS = SequenceSettings()


def followed(*numbers, publishers=1):
    monitor = SequenceMonitor(lambda: publishers)
    for number in numbers:
        monitor.note(number)
    return monitor


def test_one_publisher_takes_no_turns_and_loses_nothing():
    monitor = followed(*range(5, 100))
    assert not monitor.alternating and monitor.lost == 0


def test_gaps_are_lost_messages():
    assert followed(1, 2, 5, 6, 10).lost == 5


@pytest.mark.parametrize('ahead', [0, 1, 95, 5000])
@pytest.mark.parametrize('burst', [1, 2, 10, 50])
def test_publishers_take_turns_in_bursts_wherever_their_numbers_stand(burst, ahead):
    numbers = [
        n
        for first in range(1, 8 * burst, burst)
        for start in (first + ahead, first)
        for n in range(start, start + burst)
    ]
    monitor = followed(*numbers, publishers=2)
    assert monitor.alternating and monitor.lost == 0


def test_publishers_take_turns_though_messages_get_lost():
    numbers = [n for k in range(0, 400, 10) for s in (k, k + 7000) for n in range(s + 1, s + 10)]
    assert followed(*numbers, publishers=2).alternating


@pytest.mark.parametrize('starts', range(5))
def test_a_publisher_that_starts_again_and_again_takes_no_turns(starts):
    monitor = followed(*range(50, 60), *(list(range(1, 10)) * starts))
    assert not monitor.alternating and monitor.lost == 0


def test_turns_are_forgotten_when_one_is_left():
    numbers = [1] + [n for k in range(1, 2 + LIMITS.returns) for n in (k, k + 1)]
    assert followed(*numbers, publishers=2).alternating
    last = numbers[-1]
    assert not followed(
        *numbers, *range(last + 1, last + 2 + LIMITS.recent), publishers=2
    ).alternating


def test_a_middleware_without_numbers_tells_nothing():
    monitor = followed(*[None, 0] * 20)
    assert not monitor.alternating and monitor.lost == 0
