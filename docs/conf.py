"""How Sphinx builds these pages: `make docs` from the root of the repository, rosdoc2 from here."""

import re
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

project = 'obs_ros'
author = 'obs_ros maintainers'
extensions = ['myst_parser', 'sphinx.ext.autodoc', 'sphinx.ext.napoleon']
html_theme = 'alabaster'
# Tables have up to six columns.
html_theme_options = {'page_width': '1200px', 'body_max_width': 'auto'}
html_show_copyright = False
myst_heading_anchors = 4
suppress_warnings = ['toc.not_included']  # README and reports are reached by links
default_role = 'code'  # docstrings quote with single backticks
add_module_names = False
autodoc_member_order = 'bysource'
autodoc_typehints = 'signature'
# Without the node, the documents of which are its pages: importing it needs ROS.
PAGES = [
    'README.md',
    'CHANGELOG.md',
    'docs/**.md',
    'benchmarks/README.md',
    'benchmarks/results/*.md',
]


def choose_pages(app: Any, config: Any) -> None:
    """Take in the pages that lie beside docs/ where that is not the whole source."""
    whole = Path(app.srcdir).resolve() == HERE.parent
    config.root_doc = 'docs/index' if whole else 'index'
    if whole:
        config.include_patterns = PAGES


def unmeasured(text: str, link: str) -> bool:
    """Whether a link is to the report of a paper that the page itself says is not there yet."""
    report = re.fullmatch(r'\.\./benchmarks/results/papers_(\w+)\.md', link)
    return report is not None and (
        f'Not measured yet: `python -m benchmarks.papers {report[1]}`' in text
    )


def unlink(app: Any, page: str, source: list[str]) -> None:
    """Leave the words of links to what no page shows.

    That are folders, what lies outside of the source, and reports that are not measured yet.
    """
    root, text = Path(app.srcdir).resolve(), source[0]

    def words_or_link(link: re.Match[str]) -> str:
        target = (root / page).parent.joinpath(link[2]).resolve()
        unwritten = not target.exists() and unmeasured(text, link[2])
        shown = root in target.parents and not target.is_dir() and not unwritten
        return link[0] if shown else link[1]

    source[0] = re.sub(r'!?\[([^]]*)\]\(([\w./-]+)(?:#[\w-]+)?\)', words_or_link, text)


def setup(app: Any) -> None:
    """Register what depends on from where the pages are built."""
    app.connect('config-inited', choose_pages)
    app.connect('source-read', unlink)
