"""Parameters of a node from which nothing is configured yet."""

from collections.abc import Mapping
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from obs_ros.core.parameter_spec import Value, plain
from obs_ros.core.texts import one_line
from obs_ros.interface.admission import check_admitted
from obs_ros.interface.parameters import CHOICE


class Draft:
    """The values that a node was given, which may be mended until it is configured.

    While it is `open` they, and those of `CHOICE`, can be set as any parameter can; what names
    code is admitted as `check_admitted` says. Whoever configures the node `close`s it.
    """

    def __init__(self, node: Node, given: Mapping[str, Any]) -> None:
        self._node = node
        self._at_start = dict(given)
        self._values: dict[str, Any] = dict(given)
        self._open = False

    def open(self, values: Mapping[str, Any] | None = None) -> None:
        """Let values be set, beginning with these; None: with those given at start."""
        if values is not None:
            self._values = dict(values)
        self._open = True
        defaults: dict[str, Value] = {spec.name: spec.default for spec in CHOICE}
        for name, value in {**defaults, **self._values}.items():
            description = ParameterDescriptor(
                description='checked and taken up by configure', dynamic_typing=True
            )
            self._node.declare_parameter(name, plain(value), description, ignore_override=True)
        self._node.add_on_set_parameters_callback(self._check)

    def close(self) -> dict[str, Any]:
        """Let no more be set; return the values as they stand, without those taken back."""
        if self._open:
            self._open = False
            self._node.remove_on_set_parameters_callback(self._check)
            names = {*self._values, *(spec.name for spec in CHOICE)}
            left = [name for name in sorted(names) if self._node.has_parameter(name)]
            self._values = {name: self._node.get_parameter(name).value for name in left}
            for name in left:
                self._node.undeclare_parameter(name)
        return self._values

    def _check(self, changes: list[Parameter]) -> SetParametersResult:
        try:
            for change in changes:
                if change.name in self._values or change.name in {spec.name for spec in CHOICE}:
                    check_admitted(change.name, change.value, self._at_start)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=one_line(error))
        return SetParametersResult(successful=True)
