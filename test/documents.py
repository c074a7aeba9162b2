"""The commands that README and docs name: found in their code, and taken apart."""

import ast
import math
import re
import shlex
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[1]
RECIPES = tuple(sorted((ROOT / 'docs' / 'recipes').glob('*.md')))
PAGES = (ROOT / 'README.md', *sorted((ROOT / 'docs').glob('*.md')), *RECIPES)
# Inline code that begins so is a command, unless it is only the command's name.
STARTS = ('ros2', 'make', 'python', 'python3', 'pip', 'colcon', 'git', 'source', 'export', 'sudo')
NUMBER = r'((?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.]))'
LONGEST_NAME = 3  # words: `ros2 topic echo`


@dataclass(frozen=True)
class Command:
    """One command as its words, where it stands, and the comment beside it."""

    words: tuple[str, ...]
    where: str
    comment: str = ''

    def __str__(self) -> str:
        return f'{self.where}: {shlex.join(self.words)}'


@dataclass
class Section:
    """The commands of one heading: those of a block stand together, terminal by terminal."""

    page: str
    heading: str
    blocks: list[list[Command]] = field(default_factory=list)

    def __str__(self) -> str:
        return f'{self.page}: {self.heading}'


def sections(text: str, page: str) -> list[Section]:
    """Return the sections of a page that have commands."""
    found = [Section(page, 'top')]
    # Pictures drawn in text hold no commands, nor do directives of Sphinx.
    silent = re.compile(r'^```(?:text|\{[\w-]+\})\n.*?^```$', flags=re.MULTILINE | re.DOTALL)
    text = silent.sub(lambda drawn: '\n' * drawn[0].count('\n'), text)
    for kind, line, content in _parts(text):
        if kind == 'heading':
            found.append(Section(page, content))
        elif kind == 'block':
            commands = [*block_commands(content, f'{page}:{line}')]
            found[-1].blocks += [commands] if commands else []
        else:
            commands = [c for code in re.findall(r'`([^`]+)`', content)
                        for c in _inline(' '.join(code.split()), f'{page}:{line}')]  # fmt: skip
            found[-1].blocks += [[command] for command in commands]
    return [section for section in found if section.blocks]


def shown_lines(text: str) -> list[str]:
    """Return the lines that a page shows as printed; `[...]` stands for lines left out."""
    blocks = re.findall(r'^```text\n(.*?)^```$', text, flags=re.MULTILINE | re.DOTALL)
    lines = [line.strip() for block in blocks for line in block.splitlines()]
    return [line for line in lines if line not in ('', '[...]')]


def alike(shown: str, printed: str, tolerance: float = 0.05) -> bool:
    """Whether two lines have the same words, and numbers that differ by a share of them at most."""
    pairs = [re.split(NUMBER, ' '.join(line.split())) for line in (shown, printed)]
    if len(pairs[0]) != len(pairs[1]) or pairs[0][::2] != pairs[1][::2]:
        return False
    numbers = zip(pairs[0][1::2], pairs[1][1::2])
    return all(math.isclose(float(a), float(b), rel_tol=tolerance) for a, b in numbers)


def python_blocks(text: str) -> list[str]:
    """Return the blocks of a page that are Python and define or import something."""
    blocks = (textwrap.dedent(part) for kind, _, part in _parts(text) if kind == 'block')
    return [block for block in blocks if _is_python(block)]


def block_commands(text: str, where: str) -> Iterator[Command]:
    """Return the commands of a block; none of one that is Python or YAML."""
    text = textwrap.dedent(text)
    if not (_is_python(text) or _is_yaml(text)):
        for line in text.replace('\\\n', ' ').splitlines():
            yield from line_commands(line, where)


def line_commands(line: str, where: str) -> Iterator[Command]:
    """Return the commands of a line; `$(ros2 pkg prefix NAME)` stays one word's part."""
    kept = re.sub(r'\$\(ros2 pkg prefix (\w+)\)', r'{prefix:\1}', line)
    kept, _, comment = kept.partition(' #')
    words: list[str] = []
    for word in [*shlex.split(kept), '&&']:
        if word != '&&':
            words.append(word)
        elif words:
            yield Command(tuple(words), where, comment.strip())
            words = []


def _inline(code: str, where: str) -> Iterator[Command]:
    words = code.split()
    if words[0] in STARTS and (
        len(words) > LONGEST_NAME or (len(words) > 1 and words[0] != 'ros2')
    ):
        yield from line_commands(code, where)


def _parts(text: str) -> Iterator[tuple[str, int, str]]:
    """Return headings, blocks of code and paragraphs, each with its line."""
    kept: list[str] = []
    begin, kind, fence = 1, 'text', False
    for number, line in enumerate([*text.splitlines(), ''], 1):
        opens = line.startswith('```')
        code = fence or opens or (line.startswith('    ') and (kind == 'block' or not kept))
        blank = kind == 'block' and not line.strip() and not fence
        now = 'block' if code or blank else 'heading' if line.startswith('#') else 'text'
        ends = opens or now != kind or now == 'heading' or (now == 'text' and not line.strip())
        if ends and kept:
            yield kind, begin, '\n'.join(kept)
            kept = []
        if not kept:
            begin = number
        kind, fence = now, fence ^ opens
        if now == 'heading':
            kept = [line.lstrip('# ')]
        elif not opens and (line.strip() or now == 'block'):
            kept.append(line)
    if kept:
        yield kind, begin, '\n'.join(kept)


def _is_python(text: str) -> bool:
    """Whether it is Python that defines or imports something: `make` alone is an expression."""
    try:
        tree = ast.parse(text)
    except SyntaxError:
        return False
    return any(not isinstance(node, ast.Expr) for node in tree.body)


def _is_yaml(text: str) -> bool:
    try:
        return isinstance(yaml.safe_load(text), dict)
    except yaml.YAMLError:
        return False
