"""Texts from outside, made fit for a line of a log or of /diagnostics."""

from collections.abc import Collection
from itertools import islice

# Limits of format: whatever comes from outside, a log and /diagnostics stay readable.
LONGEST = 200  # characters of one text from outside
LONGEST_NAME = 100  # characters of one of many names
MOST_LISTED = 40  # names
LONGEST_LINE = 2000  # characters of a whole message


def quoted(value: object, longest: int = LONGEST) -> str:
    """Return the repr of a text, an exception or a value, in printable characters on one line.

    A text longer than `longest` characters is cut, and its number of characters added.
    """
    if isinstance(value, str | bytes):
        # A repr of the whole may be much larger than the text.
        text, size = repr(value[:longest]), len(value)
    else:
        try:
            # Of several arguments, as a SyntaxError has, the text says more.
            several = isinstance(value, BaseException) and len(value.args) != 1
            text = f'{type(value).__name__}({str(value)!r})' if several else repr(value)
        except Exception as error:
            text = f'{type(value).__name__}, whose repr raises {type(error).__name__}'
        size = len(text)
    shown = _printable(text)
    if size <= longest and len(shown) <= longest + 2:
        return shown
    return f'{shown[:longest]}... ({size} characters)'


def one_line(text: object, longest: int = LONGEST_LINE) -> str:
    """Return a message in printable characters on one line, of at most `longest` characters."""
    try:
        whole = str(text)
    except Exception as error:
        whole = f'{type(text).__name__}, whose text raises {type(error).__name__}'
    # Only the part that may be shown is looked at.
    shown = _printable(' '.join(whole[: 2 * longest].split()))
    return shown if len(shown) <= longest else f'{shown[: longest - 3]}...'


def listing(texts: Collection[str]) -> str:
    """Return the first of the texts side by side, and how many more there are."""
    first = [one_line(text, LONGEST_NAME) for text in islice(texts, MOST_LISTED)]
    more = len(texts) - len(first)
    return ', '.join(first) + (f' and {more} more' if more else '')


def _printable(text: str) -> str:
    """Return the text with escape sequences, line ends and halves of characters spelt out."""
    if text.isprintable():
        return text
    return ''.join(c if c.isprintable() else ascii(c)[1:-1] for c in text)
