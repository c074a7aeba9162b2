"""The parts of the compiled linearly implicit step that are made for one model."""

from collections.abc import Callable
from importlib.resources import files
from typing import Any

from obs_ros.core.derivatives import Linearisation, linearisation
from obs_ros.core.elimination import elimination, is_looped
from obs_ros.core.model import Model
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
    if is_looped(linear.n, linear.places):
        return [stages(linear, inputs), lanes_of(linear, inputs), text_in('kernels_looped.py')]
    return [stages(linear, inputs), text_in('kernels_rosenbrock.py'), step]


def text_in(name: str) -> str:
    """Return the text of one of the files of kernels."""
    return files('obs_ros.integration').joinpath(name).read_text(encoding='utf-8')


def lanes_of(linear: Linearisation, inputs: int) -> str:
    """Text of what the looped kernels need beside the stages: the matrix, and inputs of lanes."""
    n, c = linear.n, {place: f'-found[{linear.n + at}]' for at, place in enumerate(linear.places)}
    entries = []
    for i in range(n):
        for j in range(n):
            entry = c.get((i, j), '0.0')
            at = f'W[np.uint64({(i * n + j) * LANES}) + lane]'
            entries.append(f'{at} = ' + (f'c + {entry}' if i == j else entry))
    inputs_at = [f'a[ROW{i} + lane]' for i in range(inputs)]
    put = [f'{each} = u[{i}]' for i, each in enumerate(inputs_at)]
    bodies = {
        'put_matrix(W, lane, found, c)': entries,
        'gather_u(a, lane)': [f'return ({"".join(f"{each}, " for each in inputs_at)})'],
        'scatter_u(a, lane, u)': put or ['pass'],
    }
    return f'N_INPUTS = {inputs}\n' + ''.join(
        f'\n@jit\ndef {signature}:\n    ' + '\n    '.join(lines) + '\n'
        for signature, lines in bodies.items()
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
