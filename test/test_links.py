"""Links of the pages lead to files and headings that are there; nothing is asked of the network."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import obs_ros
from obs_ros.core.registry import meant

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted(
    path for pattern in ('*.md', 'docs/**/*.md', 'benchmarks/*.md', 'benchmarks/results/*.md')
    for path in ROOT.glob(pattern)
)  # fmt: skip
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


def unmeasured(page, path):
    """Whether the link is to a report that the page itself says is not there yet."""
    report = re.fullmatch(r'\.\./benchmarks/results/papers_(\w+)\.md', path)
    return report and f'Not measured yet: `python -m benchmarks.papers {report[1]}`' in (
        page.read_text()
    )


def dead(page):
    """The links of a page that lead nowhere."""
    for link in LINK.findall(prose(page.read_text())):
        path, _, anchor = link.partition('#')
        if '://' in link or link.startswith('mailto:') or unmeasured(page, path):
            continue
        target = (page.parent / path).resolve() if path else page
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


def test_every_page_is_in_the_index():
    index = (ROOT / 'docs' / 'index.md').read_text()
    listed = {line for block in re.findall(r'```\{toctree}\n(.*?)```', index, re.DOTALL)
              for line in block.splitlines() if line and not line.startswith(':')}  # fmt: skip
    assert listed == {page.stem for page in (ROOT / 'docs').glob('*.md')} - {'index'}


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
