"""Whether a plant's function stands already as kernels want it: straight-line, on numbers only."""

import builtins
import dis
from types import CodeType, FunctionType
from typing import Any

import numpy as np

from obs_ros.core.fingerprint import loaded, of_library, used_globals
from obs_ros.core.selects import makes_arrays

# Of Python's own functions, those that compile to arithmetic.
_ARITHMETIC = {'abs', 'float'}
# Slow as they are written; recorded, they become products, roots and `selects`.
_POWERS = (np.power, np.float_power)
# Loops, arrays and lists, matrix products.
_MAKERS = {'BUILD_LIST', 'STORE_SUBSCR', 'FOR_ITER', 'MAKE_FUNCTION'}


def is_straight(function: FunctionType, seen: frozenset[FunctionType] = frozenset()) -> bool:
    """Whether neither the function nor its helpers have loops, inner functions, arrays or lists.

    Such a function is compiled, and run on arrays over candidates, as it was written.
    """
    if function in seen:
        return True
    steps = list(dis.get_instructions(function.__code__))
    for before, step in zip([None, *steps], steps, strict=False):
        if (
            step.opname in _MAKERS
            or 'JUMP_BACKWARD' in step.opname
            or (step.opname == 'BINARY_OP' and step.argrepr.startswith('@'))
            or (step.opname == 'BINARY_OP' and step.argrepr.startswith('**') and not _whole(before))
            or (step.opname == 'LOAD_GLOBAL' and _is_foreign(step.argval, function))
        ):
            return False
    if any(isinstance(constant, CodeType) for constant in function.__code__.co_consts):
        return False
    if any(_makes_arrays(each) or any(each is one for one in _POWERS) for each in loaded(function)):
        return False
    used = [value for _, value in used_globals(function)]
    used += [cell.cell_contents for cell in function.__closure__ or ()]
    used += list(loaded(function))
    helpers = (getattr(value, 'py_func', value) for value in used)
    return all(
        is_straight(helper, seen | {function})
        for helper in helpers
        if isinstance(helper, FunctionType) and not of_library(helper)
    )


def _whole(exponent: dis.Instruction | None) -> bool:
    """Whether an instruction loads a whole number: the power by it compiles to products."""
    return exponent is not None and 'LOAD' in exponent.opname and type(exponent.argval) is int


def _makes_arrays(value: Any) -> bool:
    return makes_arrays(value) or getattr(value, '__name__', '') == 'numpy.linalg'


def _is_foreign(name: str, function: FunctionType) -> bool:
    """Whether a global is one of Python's own functions that may not compile to arithmetic."""
    return name not in function.__globals__ and hasattr(builtins, name) and name not in _ARITHMETIC
