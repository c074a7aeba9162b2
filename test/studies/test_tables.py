import csv

import numpy as np
import pytest

from obs_ros.replay.extras import MissingPackageError
from obs_ros.studies import tables
from obs_ros.studies.result import Result
from obs_ros.studies.tables import Block, csv_table, header, parquet_table

T = np.array([0.1, np.nan])
OUTCOMES = ['converged', 'x, "y"']
BLOCKS = [
    Block(
        {'recording': 'a', 'seed': '1'},
        Result({'t': T, 'stamp_ns': np.array([1, 2**62]), 'outcome': OUTCOMES}, {}),
    ),
    Block({'recording': 'b', 'seed': '2'}, Result({'t': T[:1] / 3.0, 'p1': T[:1]}, {})),
]


def test_the_header_has_the_columns_of_every_run():
    assert header(BLOCKS) == {
        'recording': str, 'seed': str, 't': float, 'stamp_ns': int, 'outcome': str, 'p1': float,
    }  # fmt: skip


def test_a_table_is_read_back_bit_by_bit(tmp_path):
    with csv_table(tmp_path / 'all.csv', header(BLOCKS)) as add:
        for block in BLOCKS:
            add(block)
    with (tmp_path / 'all.csv').open() as file:
        rows = list(csv.DictReader(file))
    assert [row['recording'] for row in rows] == ['a', 'a', 'b']
    assert [float(row['t']) for row in rows[::2]] == [0.1, 0.1 / 3.0]
    assert [row['stamp_ns'] for row in rows] == ['1', str(2**62), '']
    assert [row['outcome'] for row in rows] == ['converged', 'x, "y"', '']
    assert [row['p1'] for row in rows] == ['', '', '0.1']


@pytest.mark.parametrize('group', [1, 100])
def test_parquet_holds_the_same(tmp_path, monkeypatch, group):
    parquet = pytest.importorskip('pyarrow.parquet')
    monkeypatch.setattr(tables, 'SETTINGS', tables.TableSettings(group=group))
    with parquet_table(tmp_path / 'all.parquet', header(BLOCKS)) as add:
        for block in BLOCKS:
            add(block)
    found = parquet.read_table(tmp_path / 'all.parquet').to_pydict()
    assert found['recording'] == ['a', 'a', 'b'] and found['seed'] == ['1', '1', '2']
    assert found['stamp_ns'] == [1, 2**62, None]
    np.testing.assert_array_equal(found['t'], [0.1, np.nan, 0.1 / 3.0])
    assert found['p1'] == [None, None, 0.1]


def test_without_pyarrow_it_is_told(tmp_path, monkeypatch):
    def missing(module, what):
        raise MissingPackageError(f'{what} needs the package {module}')

    monkeypatch.setattr(tables, 'require', missing)
    with (
        pytest.raises(MissingPackageError, match='writing Parquet needs the package pyarrow'),
        parquet_table(tmp_path / 'all.parquet', {}),
    ):
        pass
