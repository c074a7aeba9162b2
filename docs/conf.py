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
    'docs/*.md',
    'benchmarks/README.md',
    'benchmarks/results/*.md',
]


def choose_pages(app: Any, config: Any) -> None:
    """Take in the pages that lie beside docs/ where that is not the whole source."""
    whole = Path(app.srcdir).resolve() == HERE.parent
    config.root_doc = 'docs/index' if whole else 'index'
    if whole:
        config.include_patterns = PAGES


def unlink(app: Any, page: str, source: list[str]) -> None:
    """Leave the words of links to folders, and to reports that no benchmark has written yet."""
    folder = (Path(app.srcdir) / page).parent

    def words_or_link(link: re.Match[str]) -> str:
        target = folder / link[2]
        unwritten = not target.exists() and link[2].startswith('../benchmarks/results/papers_')
        return link[1] if target.is_dir() or unwritten else link[0]

    source[0] = re.sub(r'\[([^]]*)\]\(([\w./-]+)\)', words_or_link, source[0])


def setup(app: Any) -> None:
    """Register what depends on from where the pages are built."""
    app.connect('config-inited', choose_pages)
    app.connect('source-read', unlink)
