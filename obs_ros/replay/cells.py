"""Cells and tables of a page of Markdown."""

import math
import warnings
from collections.abc import Iterable, Sequence

import numpy as np

from obs_ros.core.model import Variable
from obs_ros.core.texts import one_line
from obs_ros.core.typing import Array


def median(values: Array) -> float:
    """Return the median of those that are not NaN; NaN if none is."""
    with warnings.catch_warnings():
        warnings.simplefilter('ignore', RuntimeWarning)
        return float(np.nanmedian(values))


def largest(values: Array) -> float:
    """Return the largest of those that are not NaN; NaN if none is."""
    return float(np.nanmax(values, initial=-math.inf)) if (~np.isnan(values)).any() else math.nan


def figure(value: float) -> str:
    """Return a number to four digits, `?` for NaN."""
    return '?' if math.isnan(value) else f'{value:.4g}'


def with_interval(value: float, lower: float, upper: float) -> str:
    """Return a number with the two ends of its interval, `?` for one that is not known."""
    ends = '?' if math.isnan(lower) or math.isnan(upper) else f'{figure(lower)} to {figure(upper)}'
    return f'{figure(value)} ({ends})'


def unit(variable: Variable) -> str:
    """Return the unit of a variable, nothing for 1."""
    return '' if variable.unit == '1' else variable.unit


def cell(text: str) -> str:
    """Return a text as one cell, shortened."""
    return one_line(text).replace('|', '\\|')


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of Markdown."""
    lines = [header, ['---'] * len(header), *rows]
    return '\n'.join('| ' + ' | '.join(cells) + ' |' for cells in lines)
