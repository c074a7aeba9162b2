"""The result of one run as columns of a table, and facts; it is stored and sent as bytes."""

import io
import json
import zipfile
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from obs_ros.core.typing import AnyArray

TYPES: Mapping[type, str] = {float: 'd', int: 'q'}
FACTS, TEXTS = 'facts', 'texts'

Column = AnyArray | Sequence[str]  # (K,), a cell for each estimate


@dataclass(frozen=True)
class Result:
    """Columns (K,) by name, of float64, int64 or texts, and facts that JSON can hold.

    What a clock has measured stands among the facts alone: the same run has the same columns.
    """

    columns: Mapping[str, Column]
    facts: Mapping[str, Any]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def to_bytes(self) -> bytes:
        """Return it as a compressed archive of NumPy."""
        texts = {name: column for name, column in self.columns.items() if is_text(column)}
        parts = {FACTS: dict(self.facts), TEXTS: texts, 'order': list(self.columns)}
        held = np.frombuffer(json.dumps(parts).encode(), dtype=np.uint8)
        numbers = {f'c.{n}': np.asarray(c) for n, c in self.columns.items() if n not in texts}
        file = io.BytesIO()
        np.savez_compressed(file, allow_pickle=False, held=held, **numbers)
        return file.getvalue()

    @staticmethod
    def from_bytes(content: bytes) -> 'Result':
        """Return what `to_bytes` has written; raises ValueError for anything else."""
        try:
            with np.load(io.BytesIO(content), allow_pickle=False) as stored:
                parts = json.loads(bytes(stored['held']))
                texts = parts[TEXTS]
                columns = {
                    name: texts[name] if name in texts else stored[f'c.{name}']
                    for name in parts['order']
                }
        except (KeyError, OSError, EOFError, zipfile.BadZipFile) as error:
            raise ValueError(f'no result of a run: {error}') from error
        return Result(columns, parts[FACTS])


class Collector:
    """Takes rows, and returns their columns."""

    def __init__(self, types: Mapping[str, type]) -> None:
        self._columns: dict[str, Any] = {
            name: [] if kind is str else array(TYPES[kind]) for name, kind in types.items()
        }

    def add(self, row: Sequence[float | int | str]) -> None:
        """Take the cells of a row, in the order of the columns."""
        for column, cell in zip(self._columns.values(), row, strict=True):
            column.append(cell)

    def columns(self) -> dict[str, Column]:
        """Return the columns: arrays (K,), or lists of texts."""
        return {
            name: column if isinstance(column, list) else np.array(column)
            for name, column in self._columns.items()
        }


def is_text(column: Column) -> bool:
    """Whether a column holds texts."""
    return not isinstance(column, np.ndarray)
