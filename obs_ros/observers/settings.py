"""Settings of an observer: a table that checks itself and declares the parameters of the node."""

from dataclasses import dataclass, field, fields
from typing import Any, TypeVar

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.parameter_spec import ParameterSpec, Value
from obs_ros.core.registry import suggest
from obs_ros.core.texts import quoted
from obs_ros.inference.innovation_gate import INNOVATION_GATE


def setting(default: Value, description: str, unit: str = '', **limits: Any) -> Any:
    """Return a field of Settings; `limits` are those of `ParameterSpec`: lower, upper, ..."""
    return field(default=default, metadata={'description': description, 'unit': unit, **limits})


@dataclass(frozen=True)
class Settings:
    """Settings of all observers that go sample by sample; a subclass adds its own.

    Raises ValueError for a value that is wrong, with its name and a right one.
    """

    longest_gap: float = setting(
        0.0,
        'stamps that go further at once start it anew; 0: 2000 s, 1e5 steps of the model at most; '
        'or 10 mean intervals if these are longer',
        's',
        lower=0.0,
        upper=10_000.0,
    )
    innovation_gate: float = setting(
        INNOVATION_GATE.limit,
        'standard deviations from what was expected beyond which an output corrects nothing; of '
        'observers without a covariance, in units of the noise that is given; 0: none',
        lower=0.0,
        upper=1e6,
    )
    gate_patience: int = setting(
        INNOVATION_GATE.patience,
        'outputs rejected in a row, after which the next one passes and a filter widens its '
        'covariance',
        lower=1,
        upper=1_000_000,
    )

    def __post_init__(self) -> None:
        for spec in parameter_specs(type(self)):
            value = getattr(self, spec.name)
            plain = value.tolist() if isinstance(value, np.generic | np.ndarray) else value
            object.__setattr__(self, spec.name, spec.coerce(plain))


Kind = TypeVar('Kind', bound=Settings)


def parameter_specs(kind: type[Settings], prefix: str = '') -> tuple[ParameterSpec, ...]:
    """Return the rows of the table, each name after `prefix`."""
    rows = []
    for f in fields(kind):
        default: Any = f.default
        rows.append(ParameterSpec(prefix + f.name, default, **f.metadata))
    return tuple(rows)


def settings_of(kind: type[Kind], given: dict[str, Any]) -> Kind:
    """Return the settings with those given; raises ValueError for unknown and wrong ones."""
    known = [f.name for f in fields(kind)]
    for name in given:
        if name not in known:
            raise ValueError(f'unknown setting {quoted(name)}: {suggest(name, known)}')
    return kind(**given)


def stamped(model: Model, observer: str, takes_discrete: bool) -> Model:
    """Return the model; raises ValueError where its time counts from the start of a window.

    That is raised, too, where the model is discrete, and the observer takes none.
    """
    if not takes_discrete and model.kind == 'discrete':
        raise ValueError(
            f'take the observer sliding_window, ekf or ukf: {observer} integrates rates, and the '
            f'dynamics of model {model.name!r} give the next state, as it is discrete'
        )
    if model.time == 'window':
        raise ValueError(
            f"use the observer sliding_window, or Model(time='stamp'): the time of model "
            f'{model.name!r} counts from the start of a window, and there are none here'
        )
    return model
