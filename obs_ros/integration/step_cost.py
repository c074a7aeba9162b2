"""The cost of one integration step by each method, counted in the operations of its functions."""

import dis
import functools
from collections.abc import Callable
from typing import Any

from obs_ros.core.derivatives import linearisation
from obs_ros.core.elimination import elimination, is_looped
from obs_ros.core.estimated_delays import plain
from obs_ros.core.model import Model
from obs_ros.core.recorder import Untraceable
from obs_ros.core.symbols import operand
from obs_ros.core.tracing import compiled, recorded, written

CALL = 8  # operations for which a root or an exponential counts
UNKNOWN = 30  # operations per state of a function that cannot be recorded


@functools.lru_cache(maxsize=256)
def cost_of_step(model: Model, method: str) -> float:
    """Return the cost of one step of a candidate, in operations on numbers."""
    sizes = len(model.states), len(model.inputs), len(model.parameters)
    n, f = len(model.states), of_dynamics(plain(model.dynamics), sizes)
    if method == 'euler':
        return f + 2.0 * n
    if method == 'rk4':
        return 4.0 * f + 14.0 * n
    linear = linearisation(model.dynamics, *sizes)
    own = float(operations(linear.function)) if linear.exact else (n + 2.0) * f
    return own + 2.0 * f + _of_systems(n, linear.places) + 20.0 * n


def _of_systems(n: int, places: tuple[tuple[int, int], ...]) -> float:
    """Return the operations to factorise one linear system, and to solve it four times."""
    if is_looped(n, places):
        return 2.0 / 3.0 * n**3 + 4.0 * 2.0 * n**2
    system = elimination(n, places, n)
    return operations(system.factored) + 4.0 * operations(system.solved)


@functools.lru_cache(maxsize=64)
def of_dynamics(function: Callable[..., Any], sizes: tuple[int, int, int]) -> float:
    """Return the operations of a plant's function of so many states, inputs and parameters."""
    try:
        recorder, results = recorded(function, sizes, sizes[0], tuple)
        text = written(recorder, [operand(result) for result in results], 'dynamics')
        return float(operations(compiled(text, 'dynamics')))
    except (Untraceable, ArithmeticError, TypeError, ValueError, AttributeError):
        return float(UNKNOWN * sizes[0])


@functools.lru_cache(maxsize=64)
def operations(function: Callable[..., Any]) -> int:
    """Return the operations of a straight-line function, by its code."""
    names = [step.opname for step in dis.get_instructions(function)]
    calls = sum(name in ('CALL', 'CALL_FUNCTION') for name in names)
    return max(1, sum(name.startswith(('BINARY', 'UNARY')) for name in names) + CALL * calls)
