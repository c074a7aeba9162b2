"""The parts of the compiled linearly implicit step that are made for one model."""

from collections.abc import Callable
from importlib.resources import files
from typing import Any

import numpy as np

from obs_ros.core.derivatives import Linearisation, linearisation
from obs_ros.core.elimination import elimination, is_looped
from obs_ros.core.model import Model
from obs_ros.integration.delayed import delay_names
from obs_ros.integration.own_steps import CONTROL
from obs_ros.integration.path import LANES


def linear_model(model: Model) -> Linearisation:
    """Return the model's derivatives."""
    sizes = len(model.states), len(model.inputs), len(model.parameters)
    return linearisation(model.dynamics, *sizes)


def made_for(model: Model) -> dict[str, Callable[..., Any]]:
    """Return the functions, by their names in the kernels, that the model's method needs."""
    if model.method != 'rosenbrock':
        return {}
    linear = linear_model(model)
    if is_looped(linear.n, linear.places):
        return {'linearised': linear.function}
    system = elimination(linear.n, linear.places, linear.n)
    return {
        'linearised': linear.function, 'factored': system.factored, 'solved': system.solved
    }  # fmt: skip


def method_texts(model: Model) -> list[str]:
    """Return the texts that end a module: what the model's method needs, and which step it is."""
    step = f'step = step_{model.method}\n'
    if model.method != 'rosenbrock':
        return [step]
    linear, inputs = linear_model(model), len(model.inputs)
    lanes = inputs_of_lanes(inputs)
    if is_looped(linear.n, linear.places):
        own = lanes_of(linear), text_in('kernels_looped.py')
        return [stages(linear, inputs), lanes, *own]
    return [stages(linear, inputs), lanes, text_in('kernels_rosenbrock.py'), step]


def own_steps_texts(model: Model) -> list[str]:
    """Return the texts of kernels in which candidates take steps of their own, if they do."""
    if not takes_own_steps(model):
        return []
    return [control(len(model.states)), text_in('kernels_own_steps.py')]


def takes_own_steps(model: Model) -> bool:
    """Whether candidates take steps of their own through a window.

    With delays that are estimated, steps are cut where late inputs change.
    """
    return model.method == 'rosenbrock' and not delay_names(model)


def control(n: int) -> str:
    """Text of what controls the steps of n states; see `own_steps.StepControl`."""
    c, at = CONTROL, '[ROW# + lane]'
    wide = repr(c.small / c.floor)
    sizes = {
        'speed_of(rates, x, floor)': f'rates[#] / max(abs(x[#]), {wide} * floor[#])',
        'size_of(e, x, y, floor)': 'e[#] / (floor[#] + max(abs(x[#]), abs(y[#])))',
    }
    texts = [
        f'FIRST, SAFETY, LONGER, SHORTER = {c.first}, {c.safety}, {c.longer}, {c.shorter}',
        f'LOW, STALLED, TINY = {c.low}, {c.stalled}, {np.finfo(np.float64).tiny!r}\n',
    ]
    for signature, entry in sizes.items():
        total = ' + '.join(f'({entry.replace("#", str(i))}) ** 2' for i in range(n))
        texts.append(f'@jit\ndef {signature}:\n    return np.sqrt({total})\n')
    for signature, entry in {
        'copy_x(x, y, lane)': f'x{at} = y{at}',
        'store(a, k, lane, x)': f'a[k, #, lane] = x{at}',
    }.items():
        lines = ''.join(f'    {entry.replace("#", str(i))}\n' for i in range(n))
        texts.append(f'@jit\ndef {signature}:\n{lines}')
    return '\n'.join(texts)


def text_in(name: str) -> str:
    """Return the text of one of the files of kernels."""
    return files('obs_ros.integration').joinpath(name).read_text(encoding='utf-8')


def lanes_of(linear: Linearisation) -> str:
    """Text that puts the matrix of one lane into those of all, for the looped kernels."""
    n, c = linear.n, {place: f'-found[{linear.n + at}]' for at, place in enumerate(linear.places)}
    entries = []
    for i in range(n):
        for j in range(n):
            entry = c.get((i, j), '0.0')
            at = f'W[np.uint64({(i * n + j) * LANES}) + lane]'
            entries.append(f'{at} = ' + (f'c + {entry}' if i == j else entry))
    return '@jit\ndef put_matrix(W, lane, found, c):\n    ' + '\n    '.join(entries) + '\n'


def inputs_of_lanes(inputs: int) -> str:
    """Text that puts the inputs of one lane into those of all, and takes them from there."""
    at = [f'a[ROW{i} + lane]' for i in range(inputs)]
    put = '\n    '.join(f'{each} = u[{i}]' for i, each in enumerate(at)) or 'pass'
    return (
        f'N_INPUTS = {inputs}\n\n'
        f'@jit\ndef gather_u(a, lane):\n    return ({"".join(f"{each}, " for each in at)})\n\n'
        f'@jit\ndef scatter_u(a, lane, u):\n    {put}\n'
    )


def stages(linear: Linearisation, inputs: int) -> str:
    """Text of the sums on the right sides of the stages' systems.

    `found` holds f (n,), the entries of df/dx, and those derivatives in time that are not zero.
    """
    n, first = linear.n, linear.n + len(linear.places)
    driven = {i: f' + a * found[{first + at}]' for at, i in enumerate(linear.moving)}
    moved = [f'found[{i}]{driven.get(i, "")}' for i in range(n)]
    both = [f'(k1[{i}] - k2[{i}])' for i in range(n)]
    slopes = [f'(u2[{i}] - u0[{i}]) * inverse' for i in range(inputs)]
    texts = {
        'slopes(u0, u2, inverse)': slopes,
        'first_stage(found, a)': moved,
        'second_stage(found, a, b, k1)': [f'{moved[i]} + b * k1[{i}]' for i in range(n)],
        'third_stage(f, a, k1, k2)': [f'f[{i}] + a * {both[i]}' for i in range(n)],
        'fourth_stage(f, a, k1, k2, k3)': [
            f'f[{i}] + a * ({both[i]} - {8 / 3!r} * k3[{i}])' for i in range(n)
        ],
    }
    return '\n'.join(
        f'@jit\ndef {signature}:\n    return ({"".join(f"{entry}, " for entry in entries)})\n'
        for signature, entries in texts.items()
    )
