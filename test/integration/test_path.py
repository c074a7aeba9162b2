"""Tests of obs_ros.integration.path."""

import numpy as np
import pytest

from obs_ros.integration.path import LANES, Path, after, joined, lanes, own, single


def path(pieces: int = 3, rows: int = 5) -> Path:
    """Pieces of 1, 2, ... s from 10 s on, an input that rises by the piece's number each s."""
    k = np.arange(rows, dtype=np.float64)
    ends = 10.0 + np.append(0.0, np.cumsum(k + 1.0))[:-1]
    return Path(pieces, ends, k + 1.0, np.ones(rows, np.int64), k[:, None], k[:, None])


@pytest.mark.parametrize(('count', 'width'), [(1, 16), (15, 16), (16, 16), (17, 32), (33, 48)])
def test_candidates_fill_whole_chunks(count: int, width: int) -> None:
    assert lanes(count) == width and width % LANES == 0


def test_a_copy_is_not_overwritten_and_has_no_row_behind_the_end() -> None:
    whole = path()
    copy = own(whole)
    whole.t[:] = 0.0
    assert copy.t.tolist() == [10.0, 11.0, 13.0, 16.0] and copy.u.shape == (4, 1)


@pytest.mark.parametrize(
    ('gone', 't', 'dt', 'u'),
    [
        (0.0, [10.0, 11.0, 13.0, 16.0], [1.0, 2.0, 3.0], [0.0, 1.0, 2.0, 3.0]),
        (1.5, [11.5, 13.0, 16.0], [1.5, 3.0], [1.5, 2.0, 3.0]),
        (5.75, [15.75, 16.0], [0.25], [7.5, 3.0]),
    ],
)
def test_a_path_is_cut_within_a_piece(
    gone: float, t: list[float], dt: list[float], u: list[float]
) -> None:
    rest = after(path(), gone)
    assert rest.pieces == len(dt) and rest.t.tolist() == t
    assert rest.dt[: rest.pieces].tolist() == dt and rest.u[:, 0].tolist() == u


def test_joined_paths_end_where_the_last_one_does() -> None:
    first, last = own(path(1)), after(path(), 1.0)
    chain = joined([first, last])
    assert chain.pieces == 3 and chain.t.tolist() == [10.0, 11.0, 13.0, 16.0]
    assert chain.dt[:3].tolist() == [1.0, 2.0, 3.0] and chain.u[:, 0].tolist() == [
        0.0,
        1.0,
        2.0,
        3.0,
    ]
    assert joined([first]) is first


def test_of_whole_pieces_a_path_is_cut_at_the_nearest_begin() -> None:
    equal = path()._replace(dt=np.full(5, 2.0))
    for gone, left in ((0.9, 3), (1.1, 2), (2.0, 2), (3.9, 1), (5.9, 1)):
        rest = after(equal, gone, whole=True)
        assert rest.pieces == left and rest.dt[:left].tolist() == [2.0] * left
        assert rest.u[0, 0] == 3 - left


def test_every_piece_is_a_path_of_its_own() -> None:
    pieces = single(path())
    assert [piece.pieces for piece in pieces] == [1, 1, 1]
    assert [piece.t.tolist() for piece in pieces] == [[10.0, 11.0], [11.0, 13.0], [13.0, 16.0]]
