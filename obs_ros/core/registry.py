"""Names that users type (models, observers, searches, scenarios) and the objects they stand for."""

import difflib
import dis
import importlib
import itertools
import traceback
from collections.abc import Collection, Mapping
from pathlib import Path

from obs_ros.core.texts import LONGEST_NAME, listing, one_line, quoted

MOST_COMPARED = 1000  # names, so that a suggestion takes no time whatever comes from outside


def lookup(kind: str, name: str, table: Mapping[str, str]) -> object:
    """Return the object that `name` stands for.

    `name` is a key of `table` (whose values are `package.module:ATTRIBUTE`) or such a path itself,
    so that users name their own objects wherever a registered name goes.

    Raises ValueError when the name is unknown (close matches are named) or the path leads nowhere.
    """
    if not isinstance(name, str):
        raise ValueError(f'{kind} must be a name, not {quoted(name)}')
    if ':' not in name and name not in table:
        raise ValueError(f'unknown {kind} {quoted(name)}: {suggest(name, table)}')
    path = table.get(name, name)
    module_name, _, attribute = path.partition(':')
    if not attribute or not all(part.isidentifier() for part in module_name.split('.')):
        raise ValueError(f'{kind} {quoted(name)} is not of the form package.module:ATTRIBUTE')
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        raise ValueError(
            f'{kind} {quoted(name)}: {quoted(error)}; is its package installed?'
        ) from error
    except Exception as error:
        # Of a wrong model, the text is this package's own.
        what = one_line(error) if isinstance(error, ValueError) else quoted(error)
        raise ValueError(f'{kind} {quoted(name)}: {what}{_line(error)}') from error
    except (KeyboardInterrupt, SystemExit) as error:
        if isinstance(error, KeyboardInterrupt) and not _raised(error):
            raise
        raise ValueError(
            f'{kind} {quoted(name)}: its module ends the process while it is imported: '
            f'{quoted(error)}{_line(error)}'
        ) from error
    if not hasattr(module, attribute):
        hint = suggest(attribute, [n for n in dir(module) if not n.startswith('_')])
        raise ValueError(
            f'{kind} {quoted(name)}: module {module_name} has no {quoted(attribute)}: {hint}'
        )
    return getattr(module, attribute)


def suggest(name: str, known: Collection[str]) -> str:
    """Say which of the `known` names the user may have meant; both may come from outside."""
    if hint := meant(name, known):
        return hint
    return f'known are {listing(sorted(known)) or "none"}'


def meant(name: str, known: Collection[str]) -> str:
    """Say which of the `known` names is like this one; empty where none is."""
    if len(name) > LONGEST_NAME:
        return ''
    likely = [k for k in itertools.islice(known, MOST_COMPARED) if len(k) <= LONGEST_NAME]
    close = difflib.get_close_matches(name, likely, n=3, cutoff=0.5)
    return 'did you mean ' + ' or '.join(map(quoted, close)) + '?' if close else ''


def _raised(error: BaseException) -> bool:
    """Whether a `raise` raised it: a signal interrupts wherever the code just is."""
    place = error.__traceback__
    while place is not None and place.tb_next is not None:
        place = place.tb_next
    return (
        place is not None
        and place.tb_frame.f_code.co_code[place.tb_lasti] == dis.opmap['RAISE_VARARGS']
    )


def _line(error: BaseException) -> str:
    """Say on which line of the user's a module failed while it was imported."""
    own, found = Path(__file__).parents[1], ''
    for frame in traceback.extract_tb(error.__traceback__):
        path = Path(frame.filename)
        if not frame.filename.startswith('<') and own not in path.parents:
            found = f' ({path.name}:{frame.lineno})'
    return '' if isinstance(error, SyntaxError) else found  # whose text says so
