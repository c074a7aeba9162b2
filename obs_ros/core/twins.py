"""Twins of functions and objects, whose code sees the substitutes by which it is recorded."""

import contextlib
import copy
import inspect
from collections.abc import Iterable
from functools import partial
from types import FunctionType, MethodType
from typing import Any

from obs_ros.core.fingerprint import of_library
from obs_ros.core.rebuild import Rebuilder
from obs_ros.core.substitutes import BUILTINS, substitute

_HEAP_TYPE = 1 << 9  # Py_TPFLAGS_HEAPTYPE
# Methods that make, copy or look into an object; all others may compute something.
_LEFT = {'__init__', '__new__', '__init_subclass__', '__getattribute__', '__setattr__',
         '__delattr__', '__del__', '__repr__', '__reduce__', '__reduce_ex__', '__getstate__',
         '__setstate__', '__copy__', '__deepcopy__', '__hash__', '__eq__'}  # fmt: skip


class Twins(Rebuilder):
    """Copies functions, bound methods, partial functions and callable objects for recording.

    Whatever they reach by globals, closures, modules and attributes of objects is copied too, with
    `substitutes` in the place of functions of NumPy and math.
    """

    def __init__(self) -> None:
        super().__init__(lambda function: function, __name__, BUILTINS)
        self._classes: dict[type, type] = {}
        self._objects: dict[int, tuple[Any, Any]] = {}  # with the original, so that ids stay

    def twin(self, value: Any, attributes: Iterable[str] = ()) -> Any:
        """Return the twin of anything callable; of numbers, arrays and the like themselves."""
        if isinstance(value, partial):
            keywords = {name: self.twin(each) for name, each in value.keywords.items()}
            return partial(self.twin(value.func), *map(self.twin, value.args), **keywords)
        if isinstance(value, MethodType):
            owner = self.twin(value.__self__)
            return MethodType(self.copy(value.__func__), owner)
        return self.instead(value, attributes)

    def instead(self, value: Any, attributes: Iterable[str]) -> Any:
        """See `Rebuilder`."""
        found = substitute(value)
        if found is not None:
            return found
        value = inspect.getattr_static(value, 'py_func', value)  # what its author compiled
        if isinstance(value, FunctionType) and value in self._above:  # it calls itself
            return lambda *values, **options: self._made[value](*values, **options)
        if isinstance(value, partial | MethodType):
            return self.twin(value)
        if isinstance(value, type) and _is_users(value):
            return self._class(value)
        if _is_users(type(value)):
            return self._object(value)
        return super().instead(value, attributes)

    def _object(self, value: Any) -> Any:
        """Return a copy of an object, of a class whose methods are copies; itself if it has none.

        What cannot be copied stays as it is: its methods are then recorded as they stand.
        """
        if id(value) in self._objects:
            return self._objects[id(value)][1]
        self._objects[id(value)] = value, value  # for an object that holds itself
        with contextlib.suppress(Exception):
            twin = copy.copy(value)
            object.__setattr__(twin, '__class__', self._class(type(value)))
            self._objects[id(value)] = value, twin
            for name, held in list(getattr(twin, '__dict__', {}).items()):
                object.__setattr__(twin, name, self.twin(held))
        return self._objects[id(value)][1]

    def _class(self, kind: type) -> type:
        """Return a subclass with copies of all methods; the class itself if it cannot have one."""
        if kind not in self._classes:
            self._classes[kind] = kind  # for methods that make objects of their own class
            with contextlib.suppress(Exception):
                self._classes[kind] = self._subclass(kind)
        return self._classes[kind]

    def _subclass(self, kind: type) -> type:
        members: dict[str, Any] = {'__slots__': ()}
        for base in reversed(kind.__mro__[:-1]):
            if not of_library(base):
                for name, member in vars(base).items():
                    with contextlib.suppress(ValueError):  # a method that calls itself
                        members[name] = self._member(name, member, members.get(name, member))
        own = {name: m for name, m in members.items() if name == '__slots__' or m is not None}
        return type(kind.__name__, (kind,), own)

    def _member(self, name: str, member: Any, otherwise: Any) -> Any:
        """Return the copy of a method, None for what the subclass inherits."""
        if name in _LEFT:
            return None
        if isinstance(member, FunctionType):
            return self.copy(member)
        if isinstance(member, property) and isinstance(member.fget, FunctionType):
            return property(self.copy(member.fget))
        if isinstance(member, staticmethod | classmethod):
            return type(member)(self.copy(member.__func__))
        return None


def _is_users(kind: type) -> bool:
    """Whether a class is written in Python, by the user."""
    return bool(kind.__flags__ & _HEAP_TYPE) and not (
        of_library(kind) or kind.__module__ in ('types', 'functools', 'typing', 'enum')
    )
