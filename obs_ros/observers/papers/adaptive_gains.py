"""Gains of adaptive observers: stored for built-in models, or in a file that the design kept."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from obs_ros.core.model import Model, names
from obs_ros.core.registry import suggest
from obs_ros.core.texts import listing, quoted
from obs_ros.core.typing import Array

LARGEST_FILE = 1_000_000  # bytes
NEEDED = ('model', 'parameters', 'L')
ALLOWED = (*NEEDED, 'B', 'H', 'scale', 'beta', 'peak', 'origin')


@dataclass(frozen=True, eq=False)
class AdaptiveGains:
    """x' = A x + Psi + B Phi2(x, u) theta, y = C x, with theta the `parameters` (q of them).

    L (n, r) corrects the states. The gradient needs B (n, l) and H (l, r) as well, with HC near
    B'P; (0, 0) arrays stand for none. `scale` (q,) is the size of each parameter in its unit.
    `beta` bounds the gain from the disturbance to C e, `peak` is the one measured; NaN: unknown.
    """

    parameters: tuple[str, ...]
    L: Array
    B: Array
    H: Array
    scale: Array
    beta: float = np.nan
    peak: float = np.nan
    origin: str = ''


def gains_of(
    model: Model,
    parameters: tuple[str, ...],
    L: Any,
    B: Any = (),
    H: Any = (),
    scale: Any = (),
    **about: Any,
) -> AdaptiveGains:
    """Return gains that fit a model, from numbers row by row or in rows; () stands for none.

    Without a `scale` it is the width of each parameter's bounds. Raises ValueError for unknown
    parameters, a wrong number of entries and what is not finite.
    """
    n, r, known = len(model.states), len(model.outputs), names(model.parameters)
    for name in parameters:
        if name not in known:
            raise ValueError(
                f'{model.name} has no parameter {quoted(name)}: {suggest(name, known)}'
            )
    if not parameters or len(set(parameters)) < len(parameters):
        raise ValueError(f'name each parameter to adapt once, not {listing(parameters) or "none"}')
    columns = np.size(B) // n
    by_h, widths = np.size(H) > 0, [_width(model, name) for name in parameters]
    if by_h != (np.size(B) > 0):
        raise ValueError('give B and H together: the gradient needs both')
    return AdaptiveGains(
        parameters=tuple(parameters),
        L=_sized('L', L, (n, r)),
        B=_sized('B', B, (n, max(columns, 1)) if by_h else (0, 0)),
        H=_sized('H', H, (max(columns, 1), r) if by_h else (0, 0)),
        scale=_positive('scale', _sized('scale', scale if np.size(scale) else widths,
                                        (len(parameters),))),
        **about,
    )  # fmt: skip


def stored_gains(model: Model, name: str) -> AdaptiveGains:
    """Return the gains of a built-in model by their `name`, or those in the file at that path.

    Raises ValueError for a model without stored gains, and as `read_gains` does.
    """
    known = BUILT_IN.get(model.name, {})
    if name in known:
        return gains_of(model, **known[name])
    if name in ('designed', 'printed'):
        raise ValueError(
            f'design gains for model {quoted(model.name)} and give their file as h_infinity.gains, '
            f'or give h_infinity.L: {name} ones are stored for {listing(sorted(BUILT_IN))} only'
        )
    return read_gains(Path(name), model)


def read_gains(path: Path, model: Model) -> AdaptiveGains:
    """Return the gains in a file that `write_gains` wrote, checked against the model.

    Raises ValueError, with the path, for a file that cannot be read, is none of gains, or holds
    those of another model.
    """
    try:
        with path.open('rb') as file:
            text = file.read(LARGEST_FILE + 1)
        if len(text) > LARGEST_FILE:
            raise ValueError(f'it has more than {LARGEST_FILE} bytes')
        content = json.loads(text)
        if not isinstance(content, dict):
            raise ValueError('it holds no object of JSON')
        return _from(content, model)
    except (OSError, ValueError, TypeError, OverflowError, RecursionError) as error:
        raise ValueError(
            'give the path of a file that `python -m obs_ros.observers.papers.design.h_infinity '
            f'--keep` wrote for {model.name}, not {quoted(str(path))}: {error}'
        ) from error


def write_gains(path: Path, model: Model, gains: AdaptiveGains) -> None:
    """Write gains as JSON, with the numbers of `read_gains` to the last bit.

    Raises OSError where the file cannot be written.
    """
    content: dict[str, Any] = {'model': model.name, 'parameters': list(gains.parameters)}
    for name in ('L', 'B', 'H', 'scale'):
        content[name] = getattr(gains, name).tolist()
    for name in ('beta', 'peak'):
        if np.isfinite(getattr(gains, name)):
            content[name] = float(getattr(gains, name))
    content['origin'] = gains.origin
    path.write_text(json.dumps(content, indent=1) + '\n', encoding='utf-8')


def _from(content: Mapping[str, Any], model: Model) -> AdaptiveGains:
    """Return what a file holds."""
    for name in NEEDED:
        if name not in content:
            raise ValueError(f'it has no {name!r}')
    for name in content:
        if name not in ALLOWED:
            raise ValueError(f'it has an unknown entry {quoted(name)}: {suggest(name, ALLOWED)}')
    if content['model'] != model.name:
        raise ValueError(f'it holds gains of model {quoted(content["model"])}')
    own = {name: value for name, value in content.items() if name not in ('model', 'parameters')}
    own |= {name: float(own[name]) for name in ('beta', 'peak') if name in own}
    chosen = content['parameters']
    if not isinstance(chosen, list) or not all(isinstance(name, str) for name in chosen):
        raise ValueError(f'its parameters are no list of names, but {quoted(chosen)}')
    return gains_of(model, tuple(chosen), **own)


def _width(model: Model, name: str) -> float:
    """Return the width of a parameter's bounds, or its size where they are infinite."""
    variable = model.variable(name)
    width = variable.upper - variable.lower
    return width if np.isfinite(width) else abs(variable.nominal or 0.0) or 1.0


def _sized(name: str, values: Any, shape: tuple[int, ...]) -> Array:
    """Return numbers in that shape."""
    array = np.array(values, dtype=np.float64)
    if array.size != np.prod(shape):
        raise ValueError(f'{name} has {array.size} entries: {" x ".join(map(str, shape))} needed')
    if not np.isfinite(array).all():
        raise ValueError(f'{name} must be finite numbers, not {quoted(array.ravel().tolist())}')
    return np.ascontiguousarray(array.reshape(shape))


def _positive(name: str, array: Array) -> Array:
    if not (array > 0.0).all():
        raise ValueError(f'{name} must be positive, not {quoted(array.tolist())}')
    return array


# By model and name, each as the arguments of `gains_of`.
BUILT_IN: Mapping[str, Mapping[str, Mapping[str, Any]]] = {
    'suspension': {
        'designed': {
            'parameters': ('kt',),
            'scale': (1e5,),
            'B': (0.0, 0.0, 0.0, 1.0),
            'L': (
                (6.3628393, 1.7052006, 4.6576387),
                (-8.5576695, 11.898975, -20.456645),
                (1.840641, 2.3718768, -0.53123582),
                (-24.799462, -19.83526, -4.9642019),
            ),
            'H': (0.00035220653, 0.00042262182, -7.0415287e-05),
            'beta': 3.01094e-05,  # m/N
            'peak': 1.46176e-05,  # m/N
            'origin': 'python -m obs_ros.observers.papers.design.h_infinity',
        },
        'printed': {
            'parameters': ('kt',),
            'scale': (1e5,),
            'B': (0.0, 0.0, 0.0, 1.0),
            # The print has lost its minus signs. Of the choices of a sign for each row's printed
            # numbers that make A - L C stable, the report of the paper says why it is this one.
            'L': (
                (0.9627, 0.9677, -0.0050),
                (1.3959, -1.0688, 2.4647),
                (0.6003, 0.5931, 0.0072),
                (-1.0688, 1.3799, -2.4487),
            ),
            'H': (0.3696, 0.3708, -0.0012),
            'origin': 'Alvarado-Méndez et al. 2024, section 5, signs restored',
        },
    },
}  # fmt: skip
