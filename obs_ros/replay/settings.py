"""The node's parameters without the node."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from obs_ros.core.model import Model
from obs_ros.core.parameter_spec import ParameterSpec, Value, check_names, ignored
from obs_ros.interface.bindings import Binding, bindings, signal_parameters
from obs_ros.interface.parameters import CHOICE, RENAMED, is_foreign, observer_parameters
from obs_ros.interface.sensors import with_sensors
from obs_ros.models import load_model


@dataclass(frozen=True)
class Setup:
    """A model, all parameters by name, and remarks on those given that mean nothing.

    `bound` are the signals bound to fields of messages, by name; see `Binding`.
    """

    model: Model
    values: Mapping[str, Value]
    bound: Mapping[str, Binding]
    remarks: tuple[str, ...]

    @property
    def merge_wait(self) -> float:
        """Time in s that samples of one stream on several topics wait for each other."""
        wait = self.values['merge_wait']
        assert isinstance(wait, float)
        return wait


def setup(given: Mapping[str, Any]) -> Setup:
    """Return what the node would start with, given these parameters.

    Raises ValueError for a value that is wrong.
    """

    def coerced(specs: Iterable[ParameterSpec]) -> dict[str, Value]:
        return {spec.name: spec.coerce(given.get(spec.name, spec.default)) for spec in specs}

    check_names(given, RENAMED)
    values = coerced(CHOICE)
    model = load_model(str(values['model']))
    values |= coerced(signal_parameters(model))
    declared = with_sensors(model, values)
    values |= coerced(observer_parameters(declared, str(values['observer'])))
    unknown = [name for name in sorted(given) if name not in values]
    signals = [name for name in unknown if name.startswith('signals.')]
    own = [name for name in unknown if not is_foreign(name)]
    remarks = (ignored(own, values),) if own else ()
    bound = bindings(model, values, signals)
    return Setup(declared, values, bound, remarks)
