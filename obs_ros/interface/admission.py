"""Values that the parameters of a node may get before anything is configured from them."""

import re
import sys
from collections.abc import Mapping
from typing import Any

from obs_ros.core.parameter_spec import MOST_ENTRIES
from obs_ros.core.texts import LONGEST, quoted
from obs_ros.interface.parameters import CHOICE
from obs_ros.models import MODELS
from obs_ros.observers.base import OBSERVERS

# Parameters that name code, and the names that mean code of this package.
_OWN_CODE = {'model': MODELS, 'observer': OBSERVERS}
_TYPE = re.compile(r'signals\..+\.type')
_CHOICE = {spec.name: spec for spec in CHOICE}
_FIXED = 'managed'  # what kind of node it is
_WRITTEN = 'checkpoint'  # the file that is written; what else had that name is moved away


def check_admitted(name: str, value: Any, given: Mapping[str, Any]) -> None:
    """Raise ValueError unless anybody may give that parameter this value before it is configured.

    What names code must be `given` at start, be code of this package, or be loaded already; what
    names a file that is written must be given at start, or empty. All else is only held to a size:
    configure checks it. None takes a value back.
    """
    if name == _FIXED:
        raise ValueError(f'start the node anew: {name} is set at start only')
    if value is None:
        return
    _check_size(name, value)
    if name in _CHOICE:
        _CHOICE[name].coerce(value)
    if not _known(name, value) and value != given.get(name):
        raise ValueError(
            f'start the node with {name} {quoted(value)}: only whoever starts it names code '
            'outside this package'
        )
    if name == _WRITTEN and value not in ('', given.get(name)):
        raise ValueError(
            f'start the node with {name} {quoted(value)}: only whoever starts it names a file that '
            'it writes'
        )


def _known(name: str, value: Any) -> bool:
    """Whether nothing is imported for the value but what this package consists of or has loaded."""
    if _TYPE.fullmatch(name):
        return f'{str(value).partition("/")[0]}.msg' in sys.modules
    return name not in _OWN_CODE or value in _OWN_CODE[name]


def _check_size(name: str, value: Any) -> None:
    """Raise ValueError for a value that would fill the memory."""
    several = isinstance(value, list | tuple)
    if several and len(value) > MOST_ENTRIES:
        raise ValueError(f'{name} must have at most {MOST_ENTRIES} entries, not {len(value)}')
    for entry in value if several else (value,):
        if isinstance(entry, str | bytes) and len(entry) > LONGEST:
            raise ValueError(f'{name} must be at most {LONGEST} characters long, not {len(entry)}')
