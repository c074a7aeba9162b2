import json
import threading

import pytest

from obs_ros.interface.vectors import Vector
from obs_ros.pages.board import Board, BoardSettings
from obs_ros.pages.information import Information, Shown

INFO = Information('tank', 'ekf', parameters=(Shown('p'),), outputs=(Shown('y'),))
SECOND = 10**9


@pytest.fixture
def board():
    board = Board(BoardSettings(silent=1e6))
    for name in ('/b/estimator', '/a/estimator'):
        board.inform(name, INFO)
    return board


def say(board, name, t, value=1.0, sd=0.1):
    board.hear(name, Vector('parameters', round(t * SECOND), {'p': value}))
    board.hear(name, Vector('parameters_stddev', round(t * SECOND), {'p': sd}))


def words(board, name='/a/estimator'):
    return {each['name']: each['words'] for each in board.answer({})['estimators']}[name]


def test_the_first_is_shown_unless_others_are_asked_for(board):
    assert [each['name'] for each in board.answer({})['shown']] == ['/a/estimator']
    both = board.answer({'of': ['/b/estimator', '/nobody', '/a/estimator']})['shown']
    assert [each['name'] for each in both] == ['/b/estimator', '/a/estimator']


def test_times_count_from_the_first_stamp(board):
    for k in range(100):
        say(board, '/a/estimator', 5000 + k)
    assert board.answer({})['origin'] == '5000000000000'
    whole, last, part = (
        board.answer(query) for query in ({}, {'span': ['10']}, {'from': ['20.5'], 'to': ['30']})
    )
    assert [(a['from'], a['to']) for a in (whole, last, part)] == [(0, 99), (89, 99), (20.5, 30)]
    (curve,) = part['shown'][0]['panels'][0]['curves']
    assert curve['t'] == [float(k) for k in range(21, 31)]


@pytest.mark.parametrize('query', [
    {'from': ['1']}, {'from': ['2'], 'to': ['1']}, {'from': ['nan'], 'to': ['1']},
    {'span': ['x']}, {'span': ['inf']}, {'from': ['-1e300'], 'to': ['1e300']}, {'points': ['[]']},
])  # fmt: skip
def test_wrong_queries_are_refused(board, query):
    with pytest.raises(ValueError):
        board.answer(query)


def test_points_are_bounded(board):
    for k in range(1000):
        say(board, '/a/estimator', k)
    counts = [
        len(board.answer({'points': [points]})['shown'][0]['panels'][0]['curves'][0]['t'])
        for points in ('-5', '100', '1e9')
    ]
    assert counts[0] <= 20 and counts[1] <= 200 and counts[2] == 1000


def test_it_is_said_how_an_estimator_is(board):
    assert words(board).startswith('no estimate heard yet')
    board.judge('/a/estimator', 1, 'compiling the model')
    assert words(board) == 'no estimate heard yet: compiling the model'
    say(board, '/a/estimator', 1)
    assert words(board) == 'compiling the model'
    board.judge('/a/estimator', 0, 'converged')
    (first, _) = board.answer({})['estimators']
    assert first == {'name': '/a/estimator', 'words': 'converged', 'well': True}
    board.attend('/a/estimator', present=False)
    assert words(board).startswith('gone for 0 s')
    board.attend('/a/estimator', present=True)
    assert words(board) == 'heard'


def test_losses_are_counted(board):
    for count in (2, 3):
        board.miss('/a/estimator', count)
    board.miss('/nobody', 1)
    shown = board.answer({'of': ['/a/estimator', '/b/estimator']})['shown']
    assert [each['lost'] for each in shown] == [5, 0]


def test_estimators_of_one_plant_are_told_from_those_of_another(board):
    board.follow('/a/estimator', '/a/output')
    board.follow('/nobody', '/b/output')
    shown = board.answer({'of': ['/a/estimator', '/b/estimator']})['shown']
    assert [each['plant'] for each in shown] == ['/a/output', '']


def test_silence_is_said():
    board = Board(BoardSettings(silent=-1.0))
    board.inform('/a/estimator', INFO)
    board.hear('/a/estimator', Vector('measured', 1, {'y': 1.0}))
    assert words(board).startswith('no estimate')  # the plant's word is not the estimator's
    say(board, '/a/estimator', 1)
    assert words(board).startswith('silent for 0 s')


def test_other_variables_begin_anew_and_the_same_go_on(board):
    say(board, '/a/estimator', 1)
    board.inform('/a/estimator', INFO)
    assert board.answer({})['shown'][0]['panels'][0]['curves']
    board.inform('/a/estimator', Information('other', 'ekf', parameters=(Shown('p'),)))
    assert not board.answer({})['shown'][0]['panels'][0]['curves']


def test_strangers_are_left_alone(board):
    board.hear('/nobody', Vector('parameters', 1, {'p': 1.0}))
    board.conclude('/nobody', 1, 'converged', '')
    board.judge('/nobody', 2, 'x')
    board.attend('/nobody', present=False)
    board.forget('/nobody')
    assert board.names == ['/a/estimator', '/b/estimator'] and board.origin is None
    board.forget('/a/estimator')
    assert board.names == ['/b/estimator']


def test_it_may_be_asked_while_it_hears(board):
    ended = threading.Event()

    def ask():
        while not ended.is_set():
            json.dumps(board.answer({}), allow_nan=False)

    asking = threading.Thread(target=ask)
    asking.start()
    for k in range(2000):
        say(board, '/a/estimator', k)
    ended.set()
    asking.join()
    assert board.answer({})['to'] == 1999.0
