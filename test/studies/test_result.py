import io

import numpy as np
import pytest

from obs_ros.studies.result import Collector, Result


def collected():
    rows = Collector({'t': float, 'stamp_ns': int, 'outcome': str})
    rows.add([0.1, 2**62, 'converged'])
    rows.add([float('nan'), 0, 'ä | b'])
    return Result(rows.columns(), {'counts': {'late': 3}, 'horizon': None})


def test_a_result_comes_back_bit_by_bit():
    before = collected()
    after = Result.from_bytes(before.to_bytes())
    assert list(after.columns) == ['t', 'stamp_ns', 'outcome'] and len(after) == 2
    for name in ('t', 'stamp_ns'):
        assert after.columns[name].dtype == before.columns[name].dtype
        assert after.columns[name].tobytes() == before.columns[name].tobytes()
    assert after.columns['outcome'] == ['converged', 'ä | b']
    assert after.facts == {'counts': {'late': 3}, 'horizon': None}
    assert collected().to_bytes() == before.to_bytes()


def test_a_result_may_have_no_rows():
    empty = Result(Collector({'t': float, 'outcome': str}).columns(), {})
    assert len(Result.from_bytes(empty.to_bytes())) == 0


def test_what_is_no_result_is_refused():
    with pytest.raises(ValueError, match='no result of a run'):
        Result.from_bytes(b'PK\3\4 damaged')
    other = io.BytesIO()
    np.savez(other, a=np.zeros(2))
    with pytest.raises(ValueError, match='no result of a run'):
        Result.from_bytes(other.getvalue())


def test_a_row_has_a_cell_for_every_column():
    with pytest.raises(ValueError):
        Collector({'t': float, 'u': float}).add([1.0])
