"""Kinks of a plant's function: where it switches, by the line that its author wrote.

A function is smooth but where its recorded operations are not: comparisons, absolute values, signs,
roots, limits and steps. Each has a switching function g(t, x, u, p) that is zero there; along a
solution, a change of the sign of g is a kink met. One-step methods lose their order at kinks
(Hairer, Norsett & Wanner 1993, section II.6).
"""

import functools
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np

from obs_ros.core.estimated_delays import is_delay, plain
from obs_ros.core.model import Model, names
from obs_ros.core.model_check import source_line
from obs_ros.core.plant_function import PerCandidate
from obs_ros.core.recorder import Operand, Recorder, Untraceable
from obs_ros.core.symbols import POWER, Symbol
from obs_ros.core.tracing import compiled, recorded, written
from obs_ros.core.typing import Array, BoolArray

_OWN = str(Path(__file__).parent)  # frames of the recorder itself
_LONGEST = 60  # characters of an expression that is shown
# Templates, and what switches them: operands whose difference, or that alone, is zero at the kink.
_SWITCHES: Mapping[str, tuple[tuple[int, int | None], ...]] = {
    **{f'{{}} {sign} {{}}': ((0, 1),) for sign in ('<', '<=', '>', '>=')},
    **{f'np.{name}({{}}, {{}})': ((0, 1),) for name in ('maximum', 'minimum', 'fmax', 'fmin')},
    **{f'np.{name}({{}})': ((0, None),) for name in ('abs', 'fabs', 'absolute', 'sign', 'sqrt',
                                                     'cbrt')},
    'np.clip({}, {}, {})': ((0, 1), (0, 2)),
    'np.heaviside({}, {})': ((0, None),),
    'np.copysign({}, {})': ((1, None),),
}  # fmt: skip
# Templates of functions in steps, and where in an interval the steps lie.
_STEPS: Mapping[str, str] = {
    **{f'np.{name}({{}})': 'np.sin(np.pi * ({}))' for name in ('floor', 'ceil', 'trunc')},
    **{f'np.{name}({{}})': 'np.cos(np.pi * ({}))' for name in ('round', 'rint')},
    **{each: 'np.sin(np.pi * ({} / {}))' for each in ('{} // {}', '{} % {}', 'np.fmod({}, {})')},
}


_POSITIVE = {f'np.{name}({{}})' for name in ('abs', 'absolute', 'fabs', 'sqrt', 'exp', 'square')}


@dataclass(frozen=True)
class Kink:
    """A place (file, line) where a function switches, and in words `where`: 'h1 - h3 = 0'."""

    file: str
    line: int
    where: str

    @property
    def place(self) -> str:
        """The file's name, the line, and what stands there."""
        return source_line(self.file, self.line)


@dataclass(frozen=True)
class Kinks:
    """The kinks of a function of (t, x, u, p), and its switching functions, one for each."""

    kinks: tuple[Kink, ...]
    switching: Callable[..., tuple[Any, ...]]

    def met(self, t: Array, x: Array, u: Array, p: Array) -> BoolArray:
        """Return which kinks (S,) a solution meets: states x (K, n), inputs u (K, m) at t (K,)."""
        if not self.kinks:
            return np.zeros(0, dtype=np.bool_)
        with np.errstate(all='ignore'):
            found = self.switching(t, tuple(x.T), tuple(u.T), tuple(p))
            g = np.array([np.broadcast_to(np.asarray(each, dtype=float), t.size) for each in found])
            before, after = np.sign(g[:, :-1]), np.sign(g[:, 1:])
            crossed = (before * after <= 0.0) & (before != after)  # neither is so for NaN
            return np.asarray(crossed.any(axis=1))


@dataclass
class PlacedRecorder(Recorder):
    """A recorder that keeps the place, file and line, where each operation was asked for first."""

    places: dict[int, tuple[str, int]] = field(default_factory=dict)

    def record(self, template: str, operands: tuple[Operand, ...]) -> int:
        """See `Recorder`."""
        number = super().record(template, operands)
        if number not in self.places:
            self.places[number] = _place()
        return number


def kinks_of(model: Model) -> Kinks:
    """Return the kinks of a model's dynamics.

    Raises Untraceable, with the reason, where the function cannot be recorded.
    """
    function = plain(model.dynamics)
    if isinstance(function, PerCandidate):
        raise Untraceable(function.reason)
    given = getattr(function, '__wrapped__', function)
    own = [v for v in model.parameters if not is_delay(v.name)]
    vectors = dict(zip('xup', map(names, (model.states, model.inputs, own)), strict=True))
    recorder, results = _recorded(given, [len(each) for each in vectors.values()])
    needed = _needed(recorder, [r.operand for r in results if isinstance(r, Symbol)])
    moving = _moving(recorder)
    words = _Words(recorder, vectors)
    found: dict[Kink, list[Operand]] = {}
    for number in needed:
        file, line = recorder.places[number]
        if file:
            for g, where in _switches(recorder, number, words):
                if moving(g):
                    found.setdefault(Kink(file, line, where), []).append(g)
    kinks = [(kink, g) for kink, each in found.items() for g in dict.fromkeys(each)]
    text = written(recorder, [g for _, g in kinks] or ['0.0'], 'switching')
    switching: FunctionType = compiled(text, 'switching')
    return Kinks(tuple(kink for kink, _ in kinks), switching)


def _recorded(given: Callable[..., Any], sizes: list[int]) -> tuple[PlacedRecorder, Sequence[Any]]:
    """Return the operations of a function that takes its vectors as tuples, or else as arrays."""
    recorder = PlacedRecorder()
    try:
        return recorder, recorded(given, sizes, sizes[0], tuple, recorder)[1]
    except Exception:
        recorder = PlacedRecorder()
        return recorder, recorded(given, sizes, sizes[0], np.array, recorder)[1]


def _switches(recorder: Recorder, number: int, words: '_Words') -> list[tuple[Operand, str]]:
    """Return the switching functions of an operation, with words on where they are zero."""
    template, operands = recorder.nodes[number]
    if template in _STEPS:
        places = operands if '{}' in template[template.index('{}') + 2 :] else operands[:1]
        return [(recorder.record(_STEPS[template], places), f'{words.of(number)} jumps')]
    found: list[tuple[Operand, str]] = []
    if (
        template == POWER
        and _is_kinked_power(operands[1])
        and not _is_positive(recorder, operands[0])
    ):
        found.append((operands[0], f'{words.of(operands[0])} = 0'))
    for first, second in _SWITCHES.get(template, ()):
        a, b = operands[first], '0' if second is None else operands[second]
        g = a if second is None else recorder.record('{} - {}', (a, b))
        # What is never below zero has its kink where it is made so.
        if (isinstance(g, int) or g in words.arguments) and not _is_positive(recorder, g):
            a, b = (a, b) if isinstance(a, int) or a in words.arguments else (b, a)
            found.append((g, f'{words.of(a)} = {words.of(b)}'))
    return found


def _is_positive(recorder: Recorder, operand: Operand) -> bool:
    """Whether an operand is never below zero, by the operations that it comes from."""
    if not isinstance(operand, int):
        return operand.replace('.', '', 1).replace('e', '', 1).isdigit()
    template, operands = recorder.nodes[operand]
    if template in ('{} * {}', '{} + {}', '{} / {}'):
        return all(_is_positive(recorder, each) for each in operands)
    if template in ('np.maximum({}, {})', 'np.fmax({}, {})'):
        return any(_is_positive(recorder, each) for each in operands)
    return template in _POSITIVE


def _is_kinked_power(exponent: Operand) -> bool:
    """Whether a constant exponent has an infinite first or second derivative at zero."""
    try:
        power = float(str(exponent).strip('()'))
    except ValueError:
        return False
    return not isinstance(exponent, int) and power != round(power) and 0.0 < power < 2.0


def _moving(recorder: Recorder) -> Callable[[Operand], bool]:
    """Return a function that tells whether an operand depends on time or states.

    Inputs switch at samples, where steps begin anyway.
    """

    @functools.cache
    def moving(operand: Operand) -> bool:
        if isinstance(operand, int):
            return any(map(moving, recorder.nodes[operand][1]))
        return operand == 't' or operand.startswith('x[')

    return moving


def _needed(recorder: Recorder, results: Sequence[Operand]) -> list[int]:
    """Return the operations that the results depend on, in their order."""
    found: set[int] = set()
    left = [each for each in results if isinstance(each, int)]
    while left:
        number = left.pop()
        if number not in found:
            found.add(number)
            left += [each for each in recorder.nodes[number][1] if isinstance(each, int)]
    return sorted(found)


class _Words:
    """Operations in the author's names of variables, as far as they are short."""

    def __init__(self, recorder: Recorder, variables: Mapping[str, Sequence[str]]) -> None:
        self._recorder = recorder
        self.arguments = {
            f'{vector}[{i}]': name
            for vector, known in variables.items()
            for i, name in enumerate(known)
        }

    def of(self, operand: Operand, depth: int = 4) -> str:
        """Return the words for an operand, '...' where they would be long."""
        if not isinstance(operand, int):
            return self.arguments.get(operand, operand.strip('()'))
        template, operands = self._recorder.nodes[operand]
        if depth == 0:
            return '...'
        inside = [
            f'({text})' if ' ' in text and not template.startswith('np.') else text
            for text in (self.of(each, depth - 1) for each in operands)
        ]
        text = template.replace('np.', '').format(*inside)
        return text if len(text) <= _LONGEST else '...'


def _place() -> tuple[str, int]:
    """Return the file and line of the innermost frame that is the user's; '' if there is none."""
    frame = sys._getframe(2)
    library = str(Path(np.__file__).parent)
    while frame is not None:
        file = frame.f_code.co_filename
        if file == _CALLER:
            return '', 0
        if not file.startswith((_OWN, library, '<')):
            return file, frame.f_lineno
        frame = frame.f_back  # type: ignore[assignment]
    return '', 0


_CALLER = __file__
