"""Message types by name, and their fields."""

import importlib
import re
from collections.abc import Mapping

from obs_ros.core.registry import suggest
from obs_ros.core.texts import quoted

_NAME = re.compile(r'[a-z][a-z0-9_]*/msg/[A-Z][A-Za-z0-9]*')


def message_type(name: str) -> type:
    """Return the class of messages called `package/msg/Type`.

    The package is imported: the name must come from whoever starts the node, and from nobody else.
    Raises ValueError for a name of another form, and where there is no such type.
    """
    if not _NAME.fullmatch(name):
        raise ValueError(f'{quoted(name)} is not of the form package/msg/Type')
    package, _, type_name = name.split('/')
    try:
        module = importlib.import_module(f'{package}.msg')
    except ModuleNotFoundError as error:
        raise ValueError(
            f'{name}: {quoted(error)}; is package {quoted(package)} installed?'
        ) from error
    kind = getattr(module, type_name, None)
    if not isinstance(kind, type) or not hasattr(kind, 'get_fields_and_field_types'):
        known = [known for known in dir(module) if known[0].isupper()]
        raise ValueError(f'package {quoted(package)} has no message {quoted(type_name)}: '
                         f'{suggest(type_name, known)}')  # fmt: skip
    return kind


def fields_of(name: str) -> Mapping[str, str]:
    """Return the types of a message's fields by name; `name` is package/Type or package/msg/Type.

    Raises ValueError as `message_type` does.
    """
    package, _, rest = name.partition('/')
    kind = message_type(f'{package}/msg/{rest.removeprefix("msg/")}')
    return dict(kind.get_fields_and_field_types())  # type: ignore[attr-defined]
