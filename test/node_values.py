"""The values of an estimator's parameters, without a node."""

from typing import Any

from obs_ros.interface.bindings import signal_parameters
from obs_ros.interface.parameters import CHOICE, observer_parameters
from obs_ros.models import load_model


def values_of(model: str, observer: str, **more: Any) -> dict[str, Any]:
    """Return the defaults, but for those given."""
    plant = load_model(model)
    specs = (*CHOICE, *signal_parameters(plant), *observer_parameters(plant, observer))
    defaults = {spec.name: spec.default for spec in specs}
    return {**defaults, 'model': model, 'observer': observer, **more}
