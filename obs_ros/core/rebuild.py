"""Copies of a plant's functions, with other helpers."""

from collections.abc import Callable, Iterable, Mapping
from types import CellType, FunctionType, ModuleType
from typing import Any

from obs_ros.core.fingerprint import loaded, of_library, used_attributes, used_globals
from obs_ros.core.selects import makes_arrays, selects

Convert = Callable[[FunctionType], Callable[..., Any]]


class Rebuilder:
    """Copies a plant's functions, with `convert` of a copy in place of every function they call.

    NumPy's functions that have a twin in `selects` are replaced by `convert` of that. The copies
    belong to `module`: what is compiled of them looks that up, which is there wherever the
    functions' own module has gone. `slow` names the functions of NumPy that were met and take
    memory at each call. `builtins` are globals that every copy sees, unless its function has own
    ones of these names.
    """

    def __init__(
        self, convert: Convert, module: str, builtins: Mapping[str, Any] | None = None
    ) -> None:
        self._convert = convert
        self._module = module
        self._builtins = dict(builtins or {})
        self._made: dict[Any, Any] = {}
        self._above: list[FunctionType | ModuleType] = []
        self.slow: set[str] = set()

    def copy(self, function: Callable[..., Any]) -> FunctionType:
        """Return the function's copy, itself not converted.

        Raises ValueError when it is no plain Python function, or calls itself.
        """
        if not isinstance(function, FunctionType):
            raise ValueError(f'{function!r} is not a plain Python function')
        if function in self._above:
            raise ValueError(f'{function.__qualname__} calls itself')
        self._above.append(function)
        self.slow.update(value.__name__ for value in loaded(function) if makes_arrays(value))
        attributes = used_attributes(function)
        scope = {**self._builtins, **function.__globals__}
        for name, value in used_globals(function):
            scope[name] = self.instead(value, attributes)
        cells = tuple(
            CellType(self.instead(cell.cell_contents, attributes))
            for cell in function.__closure__ or ()
        )
        self._above.pop()
        copy = FunctionType(
            function.__code__, scope, function.__name__, function.__defaults__, cells
        )
        copy.__kwdefaults__ = function.__kwdefaults__
        copy.__module__ = self._module
        copy.__qualname__ = function.__qualname__
        return copy

    def instead(self, value: Any, attributes: Iterable[str]) -> Any:
        """Return what stands in the copy for a value that the function uses."""
        if isinstance(value, ModuleType):
            return self._module_instead(value, attributes)
        called = next((select for numpy, select in selects().items() if numpy is value), value)
        if not isinstance(called, FunctionType) or of_library(called):
            return value
        if called not in self._made:
            self._made[called] = self._convert(self.copy(called))
        return self._made[called]

    def _module_instead(self, module: ModuleType, attributes: Iterable[str]) -> ModuleType:
        """Return the module, or a twin with some of these attributes replaced."""
        if module in self._above:  # modules may name each other
            return module
        inside = {name: getattr(module, name) for name in attributes if hasattr(module, name)}
        # The attribute of another module may have a namesake here, even the function that uses it.
        inside = {
            name: value
            for name, value in inside.items()
            if not any(value is each for each in self._above)
        }
        self._above.append(module)
        new = {name: self.instead(value, attributes) for name, value in inside.items()}
        self._above.pop()
        if all(new[name] is inside[name] for name in new):
            return module
        twin = ModuleType(module.__name__)
        twin.__dict__.update(module.__dict__, **new)
        return twin
