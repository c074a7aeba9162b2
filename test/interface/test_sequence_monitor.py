import pytest

from obs_ros.interface.sequence_monitor import RECENT, RETURNS, Turns


def followed(*numbers, publishers=1):
    turns = Turns(lambda: publishers)
    for number in numbers:
        turns.note(number)
    return turns


def test_one_publisher_takes_no_turns_and_loses_nothing():
    turns = followed(*range(5, 100))
    assert not turns.taken and turns.lost == 0


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
    turns = followed(*numbers, publishers=2)
    assert turns.taken and turns.lost == 0


def test_publishers_take_turns_though_messages_get_lost():
    numbers = [n for k in range(0, 400, 10) for s in (k, k + 7000) for n in range(s + 1, s + 10)]
    assert followed(*numbers, publishers=2).taken


@pytest.mark.parametrize('starts', range(5))
def test_a_publisher_that_starts_again_and_again_takes_no_turns(starts):
    turns = followed(*range(50, 60), *(list(range(1, 10)) * starts))
    assert not turns.taken and turns.lost == 0


def test_turns_are_forgotten_when_one_is_left():
    numbers = [1] + [n for k in range(1, 2 + RETURNS) for n in (k, k + 1)]
    assert followed(*numbers, publishers=2).taken
    last = numbers[-1]
    assert not followed(*numbers, *range(last + 1, last + 2 + RECENT), publishers=2).taken


def test_a_middleware_without_numbers_tells_nothing():
    turns = followed(*[None, 0] * 20)
    assert not turns.taken and turns.lost == 0
