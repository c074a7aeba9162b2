"""~/info: model and settings of a node as YAML, for people and tools that come late too."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import yaml
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import String

from obs_ros.core.model import Model, Variable
from obs_ros.core.variable_fields import SENSOR_FIELDS
from obs_ros.ros.messages import LATCHED


def publish_info(node: Node) -> Callable[[Mapping[str, Any]], None]:
    """Return a function that publishes a mapping on the latched topic ~/info."""
    return info_on(node.create_publisher(String, '~/info', LATCHED))


def info_on(publisher: Publisher) -> Callable[[Mapping[str, Any]], None]:
    """Return a function that publishes a mapping there."""
    return lambda info: publisher.publish(
        String(data=yaml.safe_dump(dict(info), sort_keys=False, default_flow_style=None))
    )


def model_info(model: Model) -> dict[str, Any]:
    """Return name and variables of a model, in the order of its vectors."""
    return {
        'model': model.name,
        'reference': model.reference,
        **({} if model.period is None else {'kind': model.kind, 'period': model.period}),
        'states': _variables(model.states),
        'inputs': _variables(model.inputs),
        'outputs': _variables(model.outputs),
        'parameters': _variables(model.parameters),
    }


def settings_info(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the node's parameters, all in one place: some are named as parts of a model are."""
    plain = {k: list(v) if isinstance(v, tuple) else v for k, v in settings.items()}
    return {'settings': plain}


def _plain(variable: Variable, field: str) -> Any:
    """Return the value of a field as YAML has it."""
    value = getattr(variable, field)
    return list(value) if isinstance(value, tuple) else value


def _variables(variables: Sequence[Variable]) -> list[dict[str, Any]]:
    return [
        {'name': v.name, 'unit': v.unit, 'bounds': [v.lower, v.upper]}
        | ({} if v.scale == 'linear' else {'scale': v.scale})
        | ({} if v.walk is None else {'walk': v.walk})
        | {
            field: _plain(v, field)
            for field in ('prior', *SENSOR_FIELDS)
            if getattr(v, field) is not None
        }
        for v in variables
    ]
