"""Derivatives of every operation that a recorded function may hold, by its template.

Where a slope is infinite while the value is finite, as of a square root at 0, it counts as 0: a
step that uses it loses order there, and nothing turns NaN.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from obs_ros.core.symbols import POWER, arithmetic, select

Partial = Callable[..., Any]  # of the operation's own value, and its operands

_LN2, _LN10 = math.log(2.0), math.log(10.0)


def _where(condition: Any, formula: Any) -> Any:
    return select(condition, formula, 0.0)


def _power(own: Any, base: Any, exponent: Any) -> Any:
    """Return the derivative of base ** exponent by the base."""
    return _where(base != 0.0, exponent * own / base)


def _product(own: Any, base: Any, exponent: int) -> Any:
    """Return the derivative of base ** exponent by the base, the exponent being whole."""
    slope = exponent * base ** (exponent - 1)
    return slope if exponent >= 1 else _where(base != 0.0, slope)


def _sinc(own: Any, a: Any) -> Any:
    return _where(a != 0.0, (np.cos(math.pi * a) - own) / a)


def _psi(a: Any) -> Any:
    return arithmetic('special.psi({})', a)


def _copied(own: Any, a: Any, b: Any) -> Any:
    return np.sign(a) * np.sign(own)


_UNARY: dict[str, Partial] = {
    '-{}': lambda y, a: -1.0,
    'np.positive({})': lambda y, a: 1.0,
    'np.conjugate({})': lambda y, a: 1.0,
    'np.sin({})': lambda y, a: np.cos(a),
    'np.cos({})': lambda y, a: -np.sin(a),
    'np.tan({})': lambda y, a: 1.0 + y * y,
    'np.arcsin({})': lambda y, a: _where(abs(a) < 1.0, 1.0 / np.sqrt(1.0 - a * a)),
    'np.arccos({})': lambda y, a: _where(abs(a) < 1.0, -1.0 / np.sqrt(1.0 - a * a)),
    'np.arctan({})': lambda y, a: 1.0 / (1.0 + a * a),
    'np.sinh({})': lambda y, a: np.cosh(a),
    'np.cosh({})': lambda y, a: np.sinh(a),
    'np.tanh({})': lambda y, a: 1.0 - y * y,
    'np.arcsinh({})': lambda y, a: 1.0 / np.sqrt(1.0 + a * a),
    'np.arccosh({})': lambda y, a: _where(a > 1.0, 1.0 / np.sqrt(a * a - 1.0)),
    'np.arctanh({})': lambda y, a: 1.0 / (1.0 - a * a),
    'np.exp({})': lambda y, a: y,
    'np.exp2({})': lambda y, a: _LN2 * y,
    'np.expm1({})': lambda y, a: y + 1.0,
    'np.log({})': lambda y, a: 1.0 / a,
    'np.log2({})': lambda y, a: 1.0 / (_LN2 * a),
    'np.log10({})': lambda y, a: 1.0 / (_LN10 * a),
    'np.log1p({})': lambda y, a: 1.0 / (1.0 + a),
    'np.sqrt({})': lambda y, a: _where(y > 0.0, 0.5 / y),
    'np.cbrt({})': lambda y, a: _where(y != 0.0, 1.0 / (3.0 * (y * y))),
    'np.square({})': lambda y, a: 2.0 * a,
    'np.reciprocal({})': lambda y, a: -(y * y),
    'np.abs({})': lambda y, a: np.sign(a),
    'np.absolute({})': lambda y, a: np.sign(a),
    'np.fabs({})': lambda y, a: np.sign(a),
    'np.degrees({})': lambda y, a: 180.0 / math.pi,
    'np.rad2deg({})': lambda y, a: 180.0 / math.pi,
    'np.radians({})': lambda y, a: math.pi / 180.0,
    'np.deg2rad({})': lambda y, a: math.pi / 180.0,
    'np.sinc({})': _sinc,
    'np.nan_to_num({})': lambda y, a: _where(np.isfinite(a), 1.0),
    'special.erf({})': lambda y, a: 2.0 / math.sqrt(math.pi) * np.exp(-(a * a)),
    'special.erfc({})': lambda y, a: -2.0 / math.sqrt(math.pi) * np.exp(-(a * a)),
    'special.gamma({})': lambda y, a: y * _psi(a),
    'special.gammaln({})': lambda y, a: _psi(a),
}

PARTIALS: dict[str, tuple[Partial, ...]] = {
    **{template: (partial,) for template, partial in _UNARY.items()},
    '{} + {}': (lambda y, a, b: 1.0, lambda y, a, b: 1.0),
    '{} - {}': (lambda y, a, b: 1.0, lambda y, a, b: -1.0),
    '{} * {}': (lambda y, a, b: b, lambda y, a, b: a),
    '{} / {}': (lambda y, a, b: 1.0 / b, lambda y, a, b: -y * (1.0 / b)),
    '{} ** {}': (_product, lambda y, a, b: 0.0),
    POWER: (_power, lambda y, a, b: _where(a > 0.0, y * np.log(a))),
    '{} % {}': (lambda y, a, b: 1.0, lambda y, a, b: -np.floor(a / b)),
    'np.fmod({}, {})': (lambda y, a, b: 1.0, lambda y, a, b: -np.trunc(a / b)),
    'np.hypot({}, {})': (
        lambda y, a, b: _where(y > 0.0, a / y),
        lambda y, a, b: _where(y > 0.0, b / y),
    ),
    'np.arctan2({}, {})': (
        lambda y, a, b: _where((a != 0.0) | (b != 0.0), b / (a * a + b * b)),
        lambda y, a, b: _where((a != 0.0) | (b != 0.0), -a / (a * a + b * b)),
    ),
    'np.logaddexp({}, {})': (lambda y, a, b: np.exp(a - y), lambda y, a, b: np.exp(b - y)),
    'np.logaddexp2({}, {})': (lambda y, a, b: np.exp2(a - y), lambda y, a, b: np.exp2(b - y)),
    'np.copysign({}, {})': (_copied, lambda y, a, b: 0.0),
    'np.nextafter({}, {})': (lambda y, a, b: 1.0, lambda y, a, b: 0.0),
}


def _greater(values: Sequence[Any], slopes: Sequence[Any]) -> Any:
    return select(values[1] > values[0], slopes[1], slopes[0])


def _less(values: Sequence[Any], slopes: Sequence[Any]) -> Any:
    return select(values[1] < values[0], slopes[1], slopes[0])


def _clipped(values: Sequence[Any], slopes: Sequence[Any]) -> Any:
    (a, low, high), (inside, lower, upper) = values, slopes
    return select(np.maximum(a, low) > high, upper, select(a < low, lower, inside))


def _chosen(values: Sequence[Any], slopes: Sequence[Any]) -> Any:
    return select(values[0], slopes[1], slopes[2])


# Of the operands' values and derivatives: the derivative of the operand that was chosen.
CHOICES: dict[str, Callable[[Sequence[Any], Sequence[Any]], Any]] = {
    'np.where({}, {}, {})': _chosen,
    'np.clip({}, {}, {})': _clipped,
    'np.maximum({}, {})': _greater,
    'np.minimum({}, {})': _less,
    'np.fmax({}, {})': _greater,
    'np.fmin({}, {})': _less,
}

# Steps and conditions: whatever they depend on, they do not change with it, but for their jumps.
CONSTANT = {
    '{} // {}', 'np.where({}, 1.0, 0.0)', 'np.sign({})', 'np.heaviside({}, {})', 'np.floor({})',
    'np.ceil({})', 'np.rint({})', 'np.trunc({})', 'np.round({})', 'np.spacing({})',
    '{} < {}', '{} <= {}', '{} > {}', '{} >= {}', '{} == {}', '{} != {}',
    'np.logical_and({}, {})', 'np.logical_or({}, {})', 'np.logical_xor({}, {})',
    'np.logical_not({})', 'np.isnan({})', 'np.isinf({})', 'np.isfinite({})', 'np.signbit({})',
}  # fmt: skip
