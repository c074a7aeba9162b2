"""The cost of one integration step, counted in recorded operations: the same on every machine."""

import ast
import functools
import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from obs_ros.core.derivatives import linearisation
from obs_ros.core.elimination import elimination
from obs_ros.core.model import Model
from obs_ros.core.tracing import traced

STAGES = {'rk4': 4, 'euler': 1, 'rosenbrock': 2}  # evaluations of f beside that of its derivatives


@dataclass(frozen=True)
class Weights:
    """Cost of operations in units of a sum or a product, as compiled lanes of candidates take it.

    - `plain`: sums, products, comparisons, selects and roundings;
    - `division`: quotients and square roots, which the processor computes in steps;
    - `function`: all other functions, and powers, which are called lane by lane.
    """

    plain: float = 1.0
    division: float = 4.0
    function: float = 120.0


WEIGHTS = Weights()
_PLAIN = {'abs', 'absolute', 'fabs', 'floor', 'ceil', 'trunc', 'rint', 'round', 'sign', 'where',
          'minimum', 'maximum', 'fmin', 'fmax', 'clip', 'square', 'copysign', 'heaviside',
          'isnan', 'isinf', 'isfinite', 'positive', 'radians', 'degrees', 'deg2rad', 'rad2deg',
          'logical_and', 'logical_or', 'logical_not', 'logical_xor', 'signbit'}  # fmt: skip


@functools.lru_cache(maxsize=64)
def step_cost(model: Model, method: str) -> float:
    """Return the cost of one step of a candidate, in units of a sum.

    A function that cannot be recorded counts as one call: only ratios of methods have a meaning.
    """
    f, n = model.dynamics, len(model.states)
    sizes = n, len(model.inputs), len(model.parameters)
    rates = _rates_cost(f, sizes)
    if method != 'rosenbrock':
        stages = STAGES[method]
        return stages * (rates + 2.0 * n)
    linear = linearisation(f, *sizes)
    system = elimination(n, linear.places, n)
    found = _cost_of(linear.function) + (0.0 if linear.exact else (n + 2) * rates)
    solving = _cost_of(system.factored) + 4.0 * _cost_of(system.solved)
    return found + solving + STAGES[method] * rates + 16.0 * n + 4.0 * len(linear.moving)


def _rates_cost(f: Callable[..., Any], sizes: tuple[int, int, int]) -> float:
    try:
        return _cost_of(traced(f, sizes, sizes[0], tuple))
    except Exception:  # whatever code that cannot be recorded raises
        return WEIGHTS.function


def _cost_of(function: Callable[..., Any]) -> float:
    """Return the cost of a straight-line function, by its text."""
    return sum(map(_cost, ast.walk(ast.parse(inspect.getsource(function)))))


_OPERATORS: Mapping[type[ast.operator], float] = {
    ast.Div: WEIGHTS.division, ast.FloorDiv: WEIGHTS.division + 1.0, ast.Mod: WEIGHTS.division + 2.0
}  # fmt: skip


def _cost(node: ast.AST) -> float:
    """Return the cost of one operation, without that of its operands."""
    if isinstance(node, ast.BinOp):
        if isinstance(node.op, ast.Pow):
            return _power_cost(node.right)
        return _OPERATORS.get(type(node.op), WEIGHTS.plain)
    if isinstance(node, ast.Compare):
        return WEIGHTS.plain
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
        name = node.func.attr
        if name in ('sqrt', 'reciprocal'):
            return WEIGHTS.division
        return WEIGHTS.plain if name in _PLAIN else WEIGHTS.function
    return 0.0


def _power_cost(exponent: ast.expr) -> float:
    """Return the cost of a power: products where the exponent is a whole number."""
    try:
        size = abs(ast.literal_eval(exponent))
    except ValueError:
        return WEIGHTS.function
    whole = isinstance(size, int) or float(size).is_integer()
    return WEIGHTS.plain * (1.0 + math.log2(1.0 + size)) if whole else WEIGHTS.function
