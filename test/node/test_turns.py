import pytest

from obs_ros.node.turns import RECENT, SWITCHES, Turns


def followed(*numbers):
    turns = Turns()
    for number in numbers:
        turns.note(number)
    return turns


def test_one_publisher_takes_no_turns_and_loses_nothing():
    turns = followed(*range(5, 100))
    assert not turns.taken and turns.lost == 0


def test_gaps_are_lost_messages():
    assert followed(1, 2, 5, 6, 10).lost == 5


@pytest.mark.parametrize('ahead', [0, 1, 95])
def test_two_publishers_take_turns_wherever_their_numbers_stand(ahead):
    numbers = [n for k in range(1, 20) for n in (k + ahead, k)]
    turns = followed(*numbers)
    assert turns.taken and turns.lost == 0


def test_a_publisher_that_starts_again_is_one_switch():
    turns = followed(*range(50, 60), *range(1, 10))
    assert not turns.taken and turns.lost == 0


def test_turns_are_forgotten_when_one_is_left():
    turns = followed(*[1, 1] * SWITCHES, *range(2, 3 + RECENT))
    assert not turns.taken


def test_a_middleware_without_numbers_tells_nothing():
    turns = followed(*[None, 0] * 20)
    assert not turns.taken and turns.lost == 0
