"""One self-contained page of HTML: the live one, or a report with its numbers inside."""

import base64
import hashlib
import html
import json
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

SCRIPTS = (
    'scales.js',
    'chart.js',
    'autocorrelation.js',
    'words.js',
    'export.js',
    'page.js',
    'controls.js',
)


def page(title: str, data: Mapping[str, Any] | None = None) -> tuple[str, str]:
    """Return a page, and the Content-Security-Policy that it needs.

    With `data`, an answer of `Board.answer`, these are what it shows; without, it asks its server
    for `data` again and again. Nothing else is loaded, and nothing else may run. The policy stands
    in the page too, for one that is opened as a file.
    """
    script = ''.join(_text(name) for name in SCRIPTS)
    style = _text('page.css')
    policy = '; '.join((
        "default-src 'none'", f'script-src {_hash(script)}', f'style-src {_hash(style)}',
        'img-src data: blob:', "connect-src 'self'" if data is None else "connect-src 'none'",
        "base-uri 'none'", "form-action 'none'",
    ))  # fmt: skip
    parts = {
        'title': html.escape(title),
        'policy': html.escape(policy),
        'style': style,
        'script': script,
        'data': 'null' if data is None else embedded(data),
    }
    text = _text('page.html')
    for name, part in parts.items():
        text = text.replace(f'<!--{name}-->', part)
    # Whom a page may be framed by is only obeyed in a header.
    return text, f"{policy}; frame-ancestors 'none'"


def embedded(data: Mapping[str, Any]) -> str:
    """Return JSON that no text inside can end or turn into HTML."""
    text = json.dumps(data, allow_nan=False, separators=(',', ':'))
    for character in '<>&':
        text = text.replace(character, f'\\u{ord(character):04x}')
    return text


def _text(name: str) -> str:
    return files('obs_ros.pages').joinpath(name).read_text(encoding='utf-8')


def _hash(text: str) -> str:
    digest = hashlib.sha256(text.encode()).digest()
    return f"'sha256-{base64.b64encode(digest).decode()}'"
