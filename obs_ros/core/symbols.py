"""Symbols that stand for numbers: whatever is computed with them is recorded."""

from collections.abc import Callable, Sequence
from functools import partial
from numbers import Real
from typing import Any

import numpy as np

from obs_ros.core.recorder import Operand, Recorder, Untraceable

NUMBERS = (Real, np.bool_)


def operand(value: Any) -> Operand:
    """Return what stands for a symbol or a number in a node."""
    if isinstance(value, Symbol):
        return value.operand
    if isinstance(value, bool | np.bool_):
        return str(bool(value))
    if not isinstance(value, Real):
        raise Untraceable(f'use real numbers, not {type(value).__name__}')
    number = int(value) if isinstance(value, int | np.integer) else float(value)
    if number != number or abs(number) == np.inf:
        return {'nan': 'np.nan', 'inf': 'np.inf', '-inf': '(-np.inf)'}[str(number)]
    return repr(number) if number >= 0 else f'({number!r})'


def arithmetic(template: str, *values: Any) -> Any:
    """Return the operation on numbers and symbols, of which conditions count as 0 and 1."""
    values = tuple(v.number() if isinstance(v, Symbol) else v for v in values)
    if template in _SHORTCUTS and (found := _shortcut(template, *values)) is not None:
        return found
    return recorded(template, values)


def compared(template: str, *values: Any) -> Any:
    """Return the condition on numbers and symbols."""
    values = tuple(v.number() if isinstance(v, Symbol) else v for v in values)
    return recorded(template, values, logical=True)


def combined(template: str, *values: Any) -> Any:
    """Return the condition on conditions."""
    conditions = [v.condition() if isinstance(v, Symbol) else bool(v) for v in values]
    return recorded(template, conditions, logical=True)


def select(condition: Any, chosen: Any, other: Any) -> Any:
    """Return np.where(condition, chosen, other) of numbers and symbols."""
    if not isinstance(condition, Symbol):
        return chosen if condition else other
    both = [chosen, other]
    if operand(chosen) == operand(other):
        return chosen
    if not all(isinstance(v, Symbol) and v.logical for v in both):
        both = [v.number() if isinstance(v, Symbol) else float(v) for v in both]
    logical = isinstance(both[0], Symbol) and both[0].logical
    return recorded('np.where({}, {}, {})', [condition.condition(), *both], logical)


def recorded(template: str, values: Sequence[Any], logical: bool = False) -> 'Symbol':
    """Return the symbol of an operation on values, at least one of them a symbol."""
    recorder = next(value.recorder for value in values if isinstance(value, Symbol))
    return Symbol(recorder, recorder.record(template, tuple(map(operand, values))), logical)


POWER = 'np.power({}, {})'  # of floats, as exponents that are whole but variable may be negative
_SHORTCUTS = ('{} + {}', '{} - {}', '{} * {}', '{} / {}', '{} ** {}')


def _shortcut(template: str, a: Any, b: Any) -> Any:
    """Return the result where a constant 0 or 1 makes the operation needless; else None."""
    zero, one = (
        [not isinstance(v, Symbol) and v == constant for v in (a, b)] for constant in (0, 1)
    )
    match template[3:-3]:
        case '+' if any(zero):
            return b if zero[0] else a
        case '-' if zero[1]:
            return a
        case '-' if zero[0]:
            return -b
        case '*' if any(zero):
            return 0.0
        case '*' if any(one):
            return b if one[0] else a
        case '/' | '**' if one[1]:
            return a
        case '**' if zero[1]:
            return 1.0
    return None


_GREATEST = 64  # whole exponents up to this become products


def raised(base: Any, exponent: Any) -> Any:
    """Return base ** exponent, which costs little where a few products, or a root, will do."""
    if isinstance(exponent, Symbol):
        return arithmetic(POWER, base, exponent)
    if float(exponent).is_integer() and abs(exponent) <= _GREATEST:
        return arithmetic('{} ** {}', base, int(exponent))
    if exponent in (0.5, 1.5):
        root = arithmetic('np.sqrt({})', base)
        return root if exponent < 1.0 else base * root
    return arithmetic(POWER, base, exponent)


def _operator(
    operation: Callable[..., Any], template: str, turned: bool = False
) -> Callable[[Any, Any], Any]:
    def apply(self: Any, other: Any) -> Any:
        if not isinstance(other, (Symbol, *NUMBERS)):
            return NotImplemented
        return operation(template, *((other, self) if turned else (self, other)))

    return apply


class Symbol:
    """A number, or a condition on numbers, that is known only when the recorded code runs."""

    __slots__ = ('logical', 'operand', 'recorder')
    __hash__ = object.__hash__

    def __init__(self, recorder: Recorder, operand: Operand, logical: bool = False) -> None:
        self.recorder = recorder
        self.operand = operand
        self.logical = logical

    def number(self) -> 'Symbol':
        """Return 1 for a condition that holds, 0 for one that does not; numbers as they are."""
        if not self.logical:
            return self
        return recorded('np.where({}, 1.0, 0.0)', [self])

    def condition(self) -> 'Symbol':
        """Return whether a number is not 0; conditions as they are."""
        return self if self.logical else recorded('{} != {}', [self, 0.0], logical=True)

    __add__ = _operator(arithmetic, '{} + {}')
    __radd__ = _operator(arithmetic, '{} + {}', turned=True)
    __sub__ = _operator(arithmetic, '{} - {}')
    __rsub__ = _operator(arithmetic, '{} - {}', turned=True)
    __mul__ = _operator(arithmetic, '{} * {}')
    __rmul__ = _operator(arithmetic, '{} * {}', turned=True)
    __truediv__ = _operator(arithmetic, '{} / {}')
    __rtruediv__ = _operator(arithmetic, '{} / {}', turned=True)
    __floordiv__ = _operator(arithmetic, '{} // {}')
    __rfloordiv__ = _operator(arithmetic, '{} // {}', turned=True)
    __mod__ = _operator(arithmetic, '{} % {}')
    __rmod__ = _operator(arithmetic, '{} % {}', turned=True)

    def __pow__(self, exponent: Any) -> Any:
        return (
            raised(self, exponent) if isinstance(exponent, (Symbol, *NUMBERS)) else NotImplemented
        )

    def __rpow__(self, base: Any) -> Any:
        return raised(base, self) if isinstance(base, NUMBERS) else NotImplemented

    __lt__ = _operator(compared, '{} < {}')
    __le__ = _operator(compared, '{} <= {}')
    __gt__ = _operator(compared, '{} > {}')
    __ge__ = _operator(compared, '{} >= {}')
    __eq__ = _operator(compared, '{} == {}')
    __ne__ = _operator(compared, '{} != {}')
    __and__ = __rand__ = _operator(combined, 'np.logical_and({}, {})')
    __or__ = __ror__ = _operator(combined, 'np.logical_or({}, {})')
    __xor__ = __rxor__ = _operator(combined, 'np.logical_xor({}, {})')

    def __invert__(self) -> Any:
        return combined('np.logical_not({})', self)

    def __neg__(self) -> Any:
        return arithmetic('-{}', self)

    def __pos__(self) -> Any:
        return self.number()

    def __abs__(self) -> Any:
        return arithmetic('np.abs({})', self)

    def __round__(self, digits: int | None = None) -> Any:
        if digits:
            raise Untraceable('use np.round without a number of digits')
        return arithmetic('np.round({})', self)

    def __floor__(self) -> Any:
        return arithmetic('np.floor({})', self)

    def __ceil__(self) -> Any:
        return arithmetic('np.ceil({})', self)

    def __trunc__(self) -> Any:
        return arithmetic('np.trunc({})', self)

    def __bool__(self) -> bool:
        return self.recorder.decide(self.condition().operand)

    def __float__(self) -> float:
        raise Untraceable(
            "use NumPy's functions on values, and np.array([...]) for arrays that hold them, "
            'where a plain float is wanted'
        )

    def __int__(self) -> int:
        raise Untraceable('use np.floor or np.trunc, and no value as an index')

    __index__ = __int__

    def __getattr__(self, name: str) -> Any:
        """Return the method by which NumPy looks for a function on arrays of objects."""
        ufunc: Any = getattr(np, name, None)
        if not isinstance(ufunc, np.ufunc):
            raise AttributeError(f'a number has no attribute {name!r}')
        return partial(on_symbols, ufunc, self)

    def __array_ufunc__(self, ufunc: Any, method: str, *values: Any, **options: Any) -> Any:
        if method != '__call__':
            raise Untraceable(f'use a loop or sum in place of np.{ufunc.__name__}.{method}')
        return elementwise(ufunc, *values, **options)


def elementwise(ufunc: Any, *values: Any, **options: Any) -> Any:
    """Return a NumPy function of symbols, or of sequences that hold some, entry by entry."""
    if options or ufunc.signature is not None or ufunc.nout != 1:
        raise Untraceable(f'use np.{ufunc.__name__} of arrays of numbers only, without options')
    return spread(lambda *entries: on_symbols(ufunc, *entries), *values)


def spread(function: Callable[..., Any], *values: Any) -> Any:
    """Return a function of entries on arrays of them, of one shape or broadcast to it."""
    arrays = [np.asarray(value, dtype=object) for value in values]
    return np.frompyfunc(function, len(arrays), 1)(*arrays)


def is_symbolic(value: Any) -> bool:
    """Whether this is a symbol, or a sequence or array that may hold one."""
    if isinstance(value, list | tuple):
        return any(map(is_symbolic, value))
    return isinstance(value, Symbol) or (isinstance(value, np.ndarray) and value.dtype == object)


_OPERATORS: dict[Any, Callable[..., Any]] = {
    np.add: lambda a, b: a + b,
    np.subtract: lambda a, b: a - b,
    np.multiply: lambda a, b: a * b,
    np.true_divide: lambda a, b: a / b,
    np.floor_divide: lambda a, b: a // b,
    np.remainder: lambda a, b: a % b,
    np.power: lambda a, b: a**b,
    np.float_power: lambda a, b: a**b,
    np.negative: lambda a: -a,
    np.positive: lambda a: +a,
    np.less: lambda a, b: a < b,
    np.less_equal: lambda a, b: a <= b,
    np.greater: lambda a, b: a > b,
    np.greater_equal: lambda a, b: a >= b,
    np.equal: lambda a, b: a == b,
    np.not_equal: lambda a, b: a != b,
    np.bitwise_and: lambda a, b: a & b,
    np.bitwise_or: lambda a, b: a | b,
    np.bitwise_xor: lambda a, b: a ^ b,
    np.invert: lambda a: ~a,
}
_COMBINING = {np.logical_and, np.logical_or, np.logical_xor, np.logical_not}
_TESTING = {np.isnan, np.isinf, np.isfinite, np.signbit}


def on_symbols(ufunc: Any, *values: Any) -> Any:
    """Return a NumPy function of numbers and symbols; raises Untraceable for none of NumPy's."""
    if not any(isinstance(value, Symbol) for value in values):
        return ufunc(*values).item()
    # NumPy's own numbers would ask NumPy again.
    values = tuple(v.item() if isinstance(v, np.generic) else v for v in values)
    if ufunc in _OPERATORS:
        return _OPERATORS[ufunc](*values)
    name = ufunc.__name__
    if not hasattr(np, name) or getattr(np, name) is not ufunc:
        raise Untraceable(f"write {name} with NumPy's functions or those of math")
    template = f'np.{name}({", ".join(["{}"] * len(values))})'
    if ufunc in _COMBINING:
        return combined(template, *values)
    return (compared if ufunc in _TESTING else arithmetic)(template, *values)
