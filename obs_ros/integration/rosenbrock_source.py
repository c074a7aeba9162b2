"""The parts of the compiled linearly implicit step that are made for one model."""

from collections.abc import Callable
from typing import Any

from obs_ros.core.derivatives import Linearisation, linearisation
from obs_ros.core.elimination import elimination
from obs_ros.core.model import Model


def linear_model(model: Model) -> Linearisation:
    """Return the model's derivatives."""
    sizes = len(model.states), len(model.inputs), len(model.parameters)
    return linearisation(model.dynamics, *sizes)


def made_for(model: Model) -> dict[str, Callable[..., Any]]:
    """Return the functions, by their names in the kernels, that the model's method needs."""
    if model.method != 'rosenbrock':
        return {}
    linear = linear_model(model)
    system = elimination(linear.n, linear.places, linear.n)
    return {
        'linearised': linear.function, 'factored': system.factored, 'solved': system.solved
    }  # fmt: skip


def stages(model: Model) -> str:
    """Text of the sums on the right sides of the stages' systems.

    `found` holds f (n,), the entries of df/dx, and those derivatives in time that are not zero.
    """
    linear = linear_model(model)
    n, first = linear.n, linear.n + len(linear.places)
    driven = {i: f' + a * found[{first + at}]' for at, i in enumerate(linear.moving)}
    moved = [f'found[{i}]{driven.get(i, "")}' for i in range(n)]
    both = [f'(k1[{i}] - k2[{i}])' for i in range(n)]
    slopes = [f'(u2[{i}] - u0[{i}]) * inverse' for i in range(len(model.inputs))]
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
