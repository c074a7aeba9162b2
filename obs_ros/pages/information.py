"""~/info and ~/outcome of an estimator, read with care: anybody may have written them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import yaml

from obs_ros.core.texts import LONGEST_NAME, one_line
from obs_ros.core.yaml_document import document
from obs_ros.samples.stream import STAMP_LIMIT

LONGEST_INFO = 200_000  # characters
LONGEST_OUTCOME = 10_000  # characters
MOST_NAMES = 24  # variables of a kind that are shown: each costs memory and a panel
KINDS = ('states', 'inputs', 'outputs', 'parameters')


@dataclass(frozen=True)
class Shown:
    """A variable: its `name` as in messages, unit, and the period of an angle or 0."""

    name: str
    unit: str = ''
    period: float = 0.0


@dataclass(frozen=True)
class Information:
    """Model, observer and variables of an estimator; `left_out` counts variables not shown."""

    model: str
    observer: str
    states: tuple[Shown, ...] = ()
    inputs: tuple[Shown, ...] = ()
    outputs: tuple[Shown, ...] = ()
    parameters: tuple[Shown, ...] = ()
    left_out: int = 0

    @classmethod
    def bounded(
        cls, model: str, observer: str, variables: Mapping[str, Sequence[Shown]]
    ) -> 'Information':
        """Return the information with the first variables of each kind, and the others counted."""
        return cls(
            model,
            observer,
            left_out=sum(max(0, len(each) - MOST_NAMES) for each in variables.values()),
            **{kind: tuple(each[:MOST_NAMES]) for kind, each in variables.items()},
        )


class Concluded(NamedTuple):
    """The outcome of an estimate, its message, and the stamp (ns) of its newest output."""

    stamp: int
    outcome: str
    message: str


class _Loader(yaml.SafeLoader):  # type: ignore[misc]
    """Knows no merging (`<<`): some hundred characters of it make a mapping that fills memory."""

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        """Leave the key `<<` to be refused: nothing is known by that tag."""


def concluded(text: str) -> Concluded | None:
    """Return what a text in YAML says; None if it has no stamp that a clock can give.

    Raises ValueError for one that no estimator writes.
    """
    found = _read('~/outcome', text, LONGEST_OUTCOME)
    stamp = found.get('stamp_ns') if isinstance(found, Mapping) else None
    if not isinstance(stamp, int) or abs(stamp) >= STAMP_LIMIT:
        return None
    return Concluded(stamp, words(found.get('outcome')), words(found.get('message')))


def information(text: str) -> Information:
    """Return what a text in YAML says.

    Raises ValueError for one that no estimator writes.
    """
    found = _read('~/info', text, LONGEST_INFO)
    settings = found.get('settings') if isinstance(found, Mapping) else None
    if not isinstance(settings, Mapping) or 'observer' not in settings:
        raise ValueError('~/info names no observer: it is not that of an estimator')
    return Information.bounded(
        one_line(words(found.get('model')), LONGEST_NAME),
        one_line(words(settings['observer']), LONGEST_NAME),
        {kind: _variables(found.get(kind)) for kind in KINDS},
    )


def _read(topic: str, text: str, longest: int) -> Any:
    """Return what a text in YAML says; raises ValueError for what is none, or too long."""
    if len(text) > longest:
        raise ValueError(f'{topic} of {len(text)} characters: {longest} at most are read')
    try:
        return document(_Loader(text))
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        raise ValueError(f'{topic} is no YAML: {one_line(error)}') from error


def words(found: Any) -> str:
    """Return a text as it is, a number in digits, and nothing of all else.

    By aliases a few characters of YAML may stand for a list whose text no memory holds.
    """
    return str(found) if isinstance(found, str | int | float) else ''


def _variables(found: Any) -> tuple[Shown, ...]:
    entries = found if isinstance(found, list) else []
    named = [each for each in entries if isinstance(each, Mapping)]
    return tuple(
        Shown(words(each['name']), _unit(each.get('unit')), _period(each.get('period')))
        for each in named
        if 0 < len(words(each.get('name'))) <= LONGEST_NAME
    )


def _unit(found: Any) -> str:
    text = one_line(words(found), LONGEST_NAME)
    return '' if text == '1' else text


def _period(found: Any) -> float:
    number = isinstance(found, int | float) and not isinstance(found, bool)
    return float(found) if number and math.isfinite(found) and found > 0 else 0.0
