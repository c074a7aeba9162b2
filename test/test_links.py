"""Links of the pages lead to files and headings that are there; nothing is asked of the network."""

import re
import runpy
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import obs_ros
from obs_ros.core.registry import meant

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted(
    path for pattern in ('*.md', 'docs/**/*.md', 'benchmarks/*.md', 'benchmarks/results/*.md')
    for path in ROOT.glob(pattern)
)  # fmt: skip
CONF = runpy.run_path(str(ROOT / 'docs' / 'conf.py'))  # what the pages are built with
LINK = re.compile(r'(?<!\\)!?\[[^]]*]\(([^)\s]+)\)')


def prose(text):
    """The page without its code, where brackets are no links."""
    text = re.sub(r'^```.*?^```$', '', text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r'(?m)(?:^$\n|\A)(?:^    .*\n?(?:^\s*$\n?)*)+', '\n', text)
    return re.sub(r'`[^`]*`', 'code', text)


def anchors(text):
    """The anchors of a page's headings, as GitHub and MyST make them."""
    text = re.sub(r'^```.*?^```$', '', text, flags=re.MULTILINE | re.DOTALL)
    found = []
    for heading in re.findall(r'^#+ (.+)$', text, flags=re.MULTILINE):
        words = re.sub(r'[^\w\- ]', '', LINK.sub('', heading).strip().lower())
        slug = words.replace(' ', '-')
        found.append(f'{slug}-{found.count(slug)}' if slug in found else slug)
    return found


def dead(page):
    """The links of a page that lead nowhere."""
    text = page.read_text()
    for link in LINK.findall(prose(text)):
        path, _, anchor = link.partition('#')
        if '://' in link or link.startswith('mailto:'):
            continue
        target = (page.parent / path).resolve() if path else page
        if not target.exists() and CONF['unmeasured'](text, path):
            continue
        if not target.exists() or ROOT not in (target, *target.parents):
            yield link
        elif anchor and target.suffix == '.md':
            known = anchors(target.read_text())
            if anchor not in known:
                yield f'{link} ({meant(anchor, known)})'


@pytest.mark.parametrize('page', PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_no_link_is_dead(page):
    assert [*dead(page)] == []


def test_dead_links_are_found(tmp_path, monkeypatch):
    monkeypatch.setitem(globals(), 'ROOT', tmp_path)
    (tmp_path / 'other.md').write_text('# A page: of `code`\n\n## Twice\n\n## Twice\n')
    page = tmp_path / 'page.md'
    page.write_text(
        '# Here\n\n[a](other.md), [b](other.md#a-page-of-code), [c](#here), [d](other.md#twice-1)\n'
        '\n[gone](gone.md) [lost](other.md#thrice) `[code](no.md)` [out](../..)\n\n    [x](y.md)\n'
    )
    assert [link.split()[0] for link in dead(page)] == ['gone.md', 'other.md#thrice', '../..']


def unlinked(root, page, text):
    """The page as Sphinx gets it."""
    source = [text]
    CONF['unlink'](SimpleNamespace(srcdir=root), page, source)
    return source[0]


def test_only_a_report_that_the_page_calls_unmeasured_may_be_missing(tmp_path, monkeypatch):
    monkeypatch.setitem(globals(), 'ROOT', tmp_path)
    page, link = tmp_path / 'docs' / 'page.md', '[r](../benchmarks/results/papers_b.md)'
    page.parent.mkdir()
    for said, words, found in (
        ('Not measured yet: `python -m benchmarks.papers b`.', 'r', 0),
        ('Not measured yet: `python -m benchmarks.papers c`.', link, 1), ('', link, 1),
    ):  # fmt: skip
        page.write_text(f'{link} {said}')
        assert len([*dead(page)]) == found
        assert unlinked(tmp_path, 'docs/page', page.read_text()) == f'{words} {said}'


def test_links_to_what_no_page_shows_are_built_as_words(tmp_path):
    (tmp_path / 'docs' / 'recipes').mkdir(parents=True)
    (tmp_path / 'README.md').touch()
    text = '[a](../README.md#top) [b](recipes) [c](gone.md) [d](https://example.org)'
    whole = '[a](../README.md#top) b [c](gone.md) [d](https://example.org)'
    assert unlinked(tmp_path, 'docs/page', text) == whole
    alone = 'a b [c](gone.md) [d](https://example.org)'
    assert unlinked(tmp_path / 'docs', 'page', text) == alone


def test_every_page_is_in_the_index():
    folder = ROOT / 'docs'
    lines = {line for block in re.findall(r'```\{toctree}\n(.*?)```',
             (folder / 'index.md').read_text(), re.DOTALL)
             for line in block.splitlines() if line and not line.startswith(':')}  # fmt: skip
    listed = {path for line in lines for path in folder.glob(f'{line}.md')}
    assert listed == {*folder.rglob('*.md')} - {folder / 'index.md'}
    assert all([*folder.glob(f'{line}.md')] for line in lines), lines


def test_every_public_name_is_on_the_page_of_the_api():
    documented = re.findall(r'auto\w+:: ([\w.]+)', (ROOT / 'docs' / 'api.md').read_text())
    assert {name.rpartition('.')[2] for name in documented} >= {*obs_ros.__all__}
    for name in documented:
        module, _, attribute = name.rpartition('.')
        assert hasattr(__import__(module, fromlist=[attribute]), attribute), name


@pytest.mark.slow
def test_the_pages_build_without_a_warning(tmp_path):
    """Which dead links are, too; `make docs` installs Sphinx."""
    pytest.importorskip('sphinx')
    pytest.importorskip('myst_parser')
    line = [sys.executable, '-m', 'sphinx', '--fail-on-warning', '-q', '-c', 'docs', '.', tmp_path]
    built = subprocess.run(line, cwd=ROOT, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    text = (tmp_path / 'docs' / 'api.html').read_text()
    assert 'solve_window' in text and 'Raises' in text
    # Napoleon takes what stands before a colon in a property's first line for its type.
    assert 'Type<span' not in text
