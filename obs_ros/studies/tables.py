"""The estimates of all runs in one table, as CSV and as Parquet."""

import csv
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from obs_ros.replay.extras import require
from obs_ros.replay.writers import written
from obs_ros.studies.result import Result, is_text

RECORDING = 'recording'


@dataclass(frozen=True)
class Block:
    """The result of one run, and the cells that are the same in all of its rows."""

    labels: Mapping[str, str]
    result: Result


@dataclass(frozen=True)
class TableSettings:
    """Limits of a table."""

    group: int = 65536  # rows that Parquet keeps together: small groups are slow to read


SETTINGS = TableSettings()


def header(blocks: Iterable[Block]) -> dict[str, type]:
    """Return the columns of the table with their types: those of every block, in their order.

    Models with other variables have other columns; cells that a run does not have stay empty.
    """
    found: dict[str, type] = {}
    for block in blocks:
        found |= dict.fromkeys(block.labels, str)
        for name, column in block.result.columns.items():
            found[name] = str if is_text(column) else int if _is_integer(column) else float
    return found


@contextmanager
def csv_table(path: Path, columns: Mapping[str, type]) -> Iterator[Any]:
    """Give a function that writes the rows of a block; numbers are read back bit by bit."""
    with path.open('w', newline='', encoding='utf-8') as file:
        rows = csv.writer(file, lineterminator='\n')
        rows.writerow(columns)

        def add(block: Block) -> None:
            count = len(block.result)
            for cells in zip(*(_cells(block, name, count) for name in columns), strict=True):
                rows.writerow(cells)

        yield add


@contextmanager
def parquet_table(path: Path, columns: Mapping[str, type]) -> Iterator[Any]:
    """Give a function that writes the rows of a block to a Parquet file.

    Raises MissingPackageError without PyArrow.
    """
    arrow = require('pyarrow', 'writing Parquet')
    parquet = require('pyarrow.parquet', 'writing Parquet')
    kinds = {float: arrow.float64(), int: arrow.int64(), str: arrow.string()}
    schema = arrow.schema([(name, kinds[kind]) for name, kind in columns.items()])
    waiting: list[Any] = []

    with parquet.ParquetWriter(path, schema) as file:

        def flush() -> None:
            if waiting:
                file.write_table(arrow.concat_tables(waiting))
                waiting.clear()

        def add(block: Block) -> None:
            count = len(block.result)
            arrays = [
                arrow.array(_values(block, name, count), field.type)
                for name, field in zip(columns, schema, strict=True)
            ]
            waiting.append(arrow.table(arrays, schema=schema))
            if sum(len(table) for table in waiting) >= SETTINGS.group:
                flush()

        yield add
        flush()


def _values(block: Block, name: str, count: int) -> Any:
    """Return a column (count,) of a block; None where it has none."""
    if name in block.labels:
        return [block.labels[name]] * count
    return block.result.columns.get(name, [None] * count)


def _cells(block: Block, name: str, count: int) -> Iterator[str]:
    values = _values(block, name, count)
    for value in values.tolist() if isinstance(values, np.ndarray) else values:
        yield '' if value is None else written(value)


def _is_integer(column: Any) -> bool:
    return bool(np.issubdtype(column.dtype, np.integer))
