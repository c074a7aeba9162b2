"""Node parameters from one table: declared, checked and documented by the same rows."""

import contextlib
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from obs_ros.core.parameter_spec import ParameterSpec, Value, check_names, ignored, plain
from obs_ros.core.texts import one_line
from obs_ros.interface.parameters import is_foreign


def given_at_start(
    node: Node,
    renamed: Mapping[str, str] | None = None,
    ours: Callable[[str], bool] = lambda name: True,
) -> dict[str, Any]:
    """Return the values by name that the user gives a node, which must declare them automatically.

    They are undeclared again, so that each row declares its own type. Of those whose names are not
    `ours` other nodes of the process take care. Raises ValueError where the user gives one of those
    that are `renamed` by its old name.
    """
    given = {
        name: parameter.value  # type: ignore[union-attr]  # annotated as its value
        for name, parameter in node.get_parameters_by_prefix('').items()
        if not is_foreign(name)
    }
    check_names(given, renamed or {})
    for name in given:
        node.undeclare_parameter(name)
    return {name: value for name, value in given.items() if ours(name)}


class Parameters:
    """The parameters of one node, with the values `given`, which are checked when declared.

    `passing` ones can be withdrawn again; then no row is immutable to rclpy, but those that are
    set at start only are refused all the same.
    """

    def __init__(self, node: Node, given: Mapping[str, Any], *, passing: bool = False) -> None:
        self._node = node
        self._passing = passing
        self._specs: dict[str, ParameterSpec] = {}
        self._values: dict[str, Value] = {}
        self._proposed: Any = None
        self._given = dict(given)
        self._unwatch: Callable[[], None] = lambda: None

    @property
    def values(self) -> Mapping[str, Any]:
        """All values by name, each of its row's type."""
        return self._values

    def declare(self, specs: Iterable[ParameterSpec]) -> None:
        """Declare parameters with the values given at start, or else their defaults.

        Raises ValueError for a given value that is wrong.
        """
        for spec in specs:
            value = spec.coerce(self._given.get(spec.name, spec.default))
            self._specs[spec.name] = spec
            self._values[spec.name] = value
            self._node.declare_parameter(
                spec.name,
                plain(value),
                ParameterDescriptor(
                    description=spec.describe(),
                    additional_constraints=spec.range,
                    read_only=spec.read_only and not self._passing,
                ),
                ignore_override=True,
            )

    def unknown(self, prefix: str) -> list[str]:
        """Return the names with that prefix that the user gave, but that no row declares."""
        return sorted(name for name in self._unknown if name.startswith(prefix))

    def withdraw(self) -> dict[str, Any]:
        """Undeclare them all; return the values that were given or have been changed since."""
        self._unwatch()
        for name in self._specs:
            self._node.undeclare_parameter(name)
        # As tuples: they take a NaN for equal to itself.
        changed = {
            name: value
            for name, value in self._values.items()
            if name in self._given or (value,) != (self._specs[name].default,)
        }
        self._specs.clear()
        return self._given | changed

    @property
    def _unknown(self) -> set[str]:
        return self._given.keys() - self._specs.keys()

    def watch(
        self, propose: Callable[[Mapping[str, Value]], Any], adopt: Callable[[Any], None]
    ) -> None:
        """Check all values now, and from now on let them change while running.

        `propose(values)` gets all values, by name, before a change takes effect; the ValueError it
        raises refuses the change with its text. `adopt(proposal)` gets what it returned once the
        change stands. Raises ValueError when the values given at start do not go together.
        """
        adopt(propose(dict(self._values)))
        if self._unknown:
            self._node.get_logger().warning(ignored(self._unknown, self._specs))

        def check(changes: list[Parameter]) -> SetParametersResult:
            try:
                values = dict(self._values)
                for change in changes:
                    if change.name in self._specs:
                        values[change.name] = self._coerced(change)
                self._proposed = values, propose(values) if values != self._values else None
            except ValueError as error:
                return SetParametersResult(successful=False, reason=one_line(error))
            return SetParametersResult(successful=True)

        def apply(_: list[Parameter]) -> None:
            values, proposal = self._proposed
            if values != self._values:
                self._values = values
                adopt(proposal)

        def unwatch() -> None:
            self._node.remove_pre_set_parameters_callback(self._widen)
            self._node.remove_on_set_parameters_callback(check)
            self._node.remove_post_set_parameters_callback(apply)

        self._node.add_pre_set_parameters_callback(self._widen)
        self._node.add_on_set_parameters_callback(check)
        self._node.add_post_set_parameters_callback(apply)
        self._unwatch = unwatch

    def _coerced(self, change: Parameter) -> Value:
        """Return the value of a change by its row; raises ValueError for one that must not be."""
        spec = self._specs[change.name]
        value = spec.coerce(change.value)
        if spec.read_only and (value,) != (self._values[change.name],):
            raise ValueError(
                f'clean the node up first: {change.name} is set before it is configured'
            )
        return value

    def _widen(self, changes: list[Parameter]) -> list[Parameter]:
        """Turn integers into floats where floats are meant; other wrong types are refused later."""
        widened = []
        for change in changes:
            spec = self._specs.get(change.name)
            with contextlib.suppress(ValueError):
                if spec is not None:
                    change = Parameter(change.name, value=plain(spec.typed(change.value)))
            widened.append(change)
        return widened
