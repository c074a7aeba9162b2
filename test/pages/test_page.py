"""A page loads nothing, lets nothing run that is not its own, and takes any text for text."""

import base64
import hashlib
import json
import re
from html.parser import HTMLParser

import pytest

from obs_ros.pages.page import SCRIPTS, embedded, page

NASTY = '</script><script>alert(1)</script><!--script--> & " \' \u2028'


class Elements(HTMLParser):
    """The elements of a page: tag, attributes and text."""

    def __init__(self, text):
        super().__init__()
        self.found = []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.found.append((tag, dict(attributes), ''))

    def handle_endtag(self, tag):
        self.found.append(('', {}, ''))

    def handle_data(self, text):
        if self.found:
            tag, attributes, before = self.found[-1]
            self.found[-1] = tag, attributes, before + text


def texts(text, tag):
    return [(attributes, inside) for name, attributes, inside in Elements(text).found
            if name == tag]  # fmt: skip


@pytest.mark.parametrize('data', [None, {'words': NASTY}])
def test_nothing_is_loaded_and_only_what_stands_there_runs(data):
    text, policy = page('Replay of ' + NASTY, data)
    for _, attributes, _ in Elements(text).found:
        assert not {'src', 'href', 'style', 'onload', 'onclick'} & set(attributes)
    assert '@import' not in text and not re.search(r'url\(', text)
    (_, stored), (kind, script) = texts(text, 'script')
    assert kind == {} and json.loads(stored) == data
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}';" in policy
    assert policy.startswith("default-src 'none'") and "frame-ancestors 'none'" in policy
    assert ("connect-src 'self'" in policy) is (data is None)
    assert 'unsafe' not in policy and '*' not in policy
    (inside,) = [a['content'] for a, _ in texts(text, 'meta') if 'http-equiv' in a]
    assert policy.startswith(inside)
    (_, title), *_ = texts(text, 'title')
    assert title == 'Replay of ' + NASTY


def test_data_cannot_end_its_element():
    assert not set('<>&') & set(embedded({'words': NASTY}))
    assert json.loads(embedded({'words': NASTY}))['words'] == NASTY
    with pytest.raises(ValueError):
        embedded({'value': float('nan')})


def test_texts_from_topics_are_never_html():
    """Only textContent and the like: no way from a text to an element or to code."""
    script = texts(page('x')[0], 'script')[1][1]
    assert 'textContent' in script and len(SCRIPTS) > 3
    for way in (
        'innerHTML', 'outerHTML', 'insertAdjacentHTML', 'document.write', 'eval(',
        'Function(', 'srcdoc', 'DOMParser', 'setHTML', 'createContextualFragment',
    ):  # fmt: skip
        assert way not in script, way
