"""Names that users type (models, observers, searches, scenarios) and the objects they stand for."""

import difflib
import importlib
import traceback
from collections.abc import Mapping
from pathlib import Path


def lookup(kind: str, name: str, table: Mapping[str, str]) -> object:
    """Return the object that `name` stands for.

    `name` is a key of `table` (whose values are `package.module:ATTRIBUTE`) or such a path itself,
    so that users name their own objects wherever a registered name goes.

    Raises ValueError when the name is unknown (close matches are named) or the path leads nowhere.
    """
    if not isinstance(name, str):
        raise ValueError(f'{kind} must be a name, not {name!r}')
    if ':' not in name and name not in table:
        raise ValueError(f'unknown {kind} {name!r}: {suggest(name, table)}')
    path = table.get(name, name)
    module_name, _, attribute = path.partition(':')
    if not attribute or not all(part.isidentifier() for part in module_name.split('.')):
        raise ValueError(f'{kind} {name!r} is not of the form package.module:ATTRIBUTE')
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        raise ValueError(f'{kind} {name!r}: {error}; is its package installed?') from error
    except Exception as error:
        what = '' if isinstance(error, ValueError) else f'{type(error).__name__}: '
        raise ValueError(f'{kind} {name!r}: {what}{error}{_line(error)}') from error
    if not hasattr(module, attribute):
        hint = suggest(attribute, [n for n in dir(module) if not n.startswith('_')])
        raise ValueError(f'{kind} {name!r}: module {module_name} has no {attribute!r}: {hint}')
    return getattr(module, attribute)


def suggest(name: str, known: Mapping[str, object] | list[str] | tuple[str, ...]) -> str:
    """Say which of the `known` names the user may have meant."""
    close = difflib.get_close_matches(name, list(known), n=3, cutoff=0.5)
    if close:
        return 'did you mean ' + ' or '.join(repr(match) for match in close) + '?'
    return 'known are ' + (', '.join(sorted(known)) or 'none')


def _line(error: Exception) -> str:
    """Say on which line of the user's a module failed while it was imported."""
    own, found = Path(__file__).parent, ''
    for frame in traceback.extract_tb(error.__traceback__):
        path = Path(frame.filename)
        if not frame.filename.startswith('<') and own not in path.parents:
            found = f' ({path.name}:{frame.lineno})'
    return '' if isinstance(error, SyntaxError) else found  # whose text says so
