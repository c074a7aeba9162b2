"""Generated modules of kernels: their names, their text, and what they call."""

import functools
import logging
import sys
import threading
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numba

from obs_ros.core.estimated_delays import plain
from obs_ros.core.fingerprint import fingerprint
from obs_ros.core.jit import OPTIONS
from obs_ros.core.kernel_cache import remembered, stored
from obs_ros.core.model import Model
from obs_ros.core.plant_function import PerCandidate
from obs_ros.core.rebuild import Rebuilder
from obs_ros.core.selects import SELECTS, SPECIAL
from obs_ros.integration.inlining import inlined
from obs_ros.integration.kernel_source import FASTMATH, filter_source, source
from obs_ros.integration.rosenbrock_source import made_for

log = logging.getLogger(__name__)
_lock = threading.Lock()


def load_filter(model: Model, d: int) -> ModuleType:
    """Return the module of a filter of d states and moving parameters; see `load_module`."""
    return load_module(model, filter_source(model, d), load_module(model))


def load_module(
    model: Model, text: str | None = None, base: ModuleType | None = None
) -> ModuleType:
    """Return the model's generated module, whose functions compile when they are first called.

    Its name is a hash of the model's code and constants, so another or edited model never meets a
    stale kernel. Without a writable cache folder everything works, but compiles in every process.
    What kernels call they share with those of the `base`, whose text begins likewise.
    """
    for kind in ('dynamics', 'output'):
        if isinstance(function := plain(getattr(model, kind)), PerCandidate):
            raise ValueError(f'{kind}: {function.reason}')
    text = source(model) if text is None else text
    twins: list[Callable[..., Any]] = [*SELECTS.values(), *SPECIAL.values()]
    functions = model.dynamics, model.output, *twins, *made_for(model).values()
    called = '' if base is None else base.__name__
    name = f'obs_ros_kernels_{fingerprint(text + called, inlined, *functions)}'
    with _lock:
        if name not in sys.modules:
            module = ModuleType(name, f'Kernels of model {model.name!r}.')
            bind(module, model, base)
            written = remembered(name, 'kernels.txt', lambda: inlined(text))
            exec(compile(written, f'<{name}>', 'exec'), module.__dict__)
            sys.modules[name] = module
        return sys.modules[name]


def code_of(function: Any) -> tuple[Any, ...]:
    """Return what a function does, wherever it stands."""
    code = function.__code__
    return code.co_code, code.co_consts, code.co_names, code.co_varnames


def bind(module: ModuleType, model: Model, base: ModuleType | None) -> None:
    """Give the generated module its decorators and the model's functions."""
    # Inlining has to happen before the loop vectoriser runs, or lanes are computed one by one.
    # Python calls entries only: its wrapper of a helper would hold, and optimise, a copy of it.
    inner = {**OPTIONS, 'forceinline': True, 'no_cpython_wrapper': True}
    inline = numba.njit(fastmath=FASTMATH, **inner)

    @functools.cache  # once for all kernels
    def announce() -> None:
        log.info('compiling the kernels of model %r: several seconds, once', model.name)

    def entry(kernel: Callable[..., None]) -> Any:
        compiled = numba.njit(fastmath=FASTMATH, **OPTIONS)(kernel)
        return stored(compiled, lambda: module.__name__, announce)

    shared = {} if base is None else vars(base)

    def jit(helper: Callable[..., Any]) -> Any:
        known = shared.get(helper.__name__)
        if known is None or code_of(known.py_func) != code_of(helper):
            return inline(helper)
        return known

    rebuilder = Rebuilder(inline, module.__name__)
    functions = {'dynamics': model.dynamics, 'output': model.output, **made_for(model)}
    module.__dict__.update(
        jit=jit,
        jit_sum=numba.njit(fastmath=FASTMATH | {'reassoc'}, **inner),
        entry=entry,
        **{
            name: shared.get(name) or inline(rebuilder.copy(each))
            for name, each in functions.items()
        },
    )
    if rebuilder.slow:
        names = ', '.join(f'np.{name}' for name in sorted(rebuilder.slow))
        log.warning(
            'model %r: use np.where, np.clip and arithmetic in place of %s, which takes memory at '
            'each call and may make it a hundred times slower', model.name, names,
        )  # fmt: skip
