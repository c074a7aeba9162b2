"""Texts from outside: whatever they are, a message about them is one short line."""

import sys
import types
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from obs_ros import Model, Variable, load_model
from obs_ros.core.parameter_spec import ParameterSpec, ignored
from obs_ros.core.record import Record
from obs_ros.core.registry import lookup, meant, suggest
from obs_ros.core.texts import LONGEST, LONGEST_LINE, listing, one_line, quoted
from obs_ros.interface.bindings import HEADER, Binding, bindings, signal_parameters
from obs_ros.interface.field_path import FieldPath, MessageError
from obs_ros.interface.readers import FieldReader, VectorReader
from obs_ros.replay.bag import Bag, Binder
from obs_ros.replay.engine import replay
from obs_ros.replay.parameter_file import parse, read_parameters
from obs_ros.replay.settings import setup
from obs_ros.replay.summary import summary
from obs_ros.replay.table import Table
from obs_ros.samples.break_detector import describe_break

NASTY = 'x\x1b[31m\r\n\u2028\u202e\udc80' + 1_000_000 * 'y'
SHORT_BUT_NASTY = 'x\x1b[31m\r\n\u2028\u202e|y'
MOST = 4 * LONGEST + 400  # characters of a message with some texts from outside in it


def each(name: str, values: list[Any]) -> pytest.MarkDecorator:
    """Parametrise; the values themselves are not for the names of tests."""
    return pytest.mark.parametrize(name, values, ids=[str(k) for k in range(len(values))])


def decent(text: str, most: int = MOST) -> bool:
    return text.isprintable() and len(text) <= most


@given(st.text(st.characters(codec=None)) | st.binary() | st.integers() | st.lists(st.text()))
def test_quoted_is_printable_short_and_the_repr_where_that_is(value: Any) -> None:
    text = quoted(value)
    assert decent(text, LONGEST + 40)
    if len(repr(value)) <= LONGEST and repr(value).isprintable():
        assert text == repr(value)


@given(st.text(st.characters(codec=None), max_size=5000))
def test_one_line_is_one_line_and_leaves_a_decent_text_alone(text: str) -> None:
    assert decent(one_line(text), LONGEST_LINE)
    if decent(text, LONGEST_LINE) and ' '.join(text.split()) == text:
        assert one_line(text) == text


def test_what_is_cut_tells_how_long_it_was() -> None:
    assert quoted(300 * 'a') == "'" + 199 * 'a' + '... (300 characters)'
    assert quoted(LONGEST * 'a') == repr(LONGEST * 'a')
    assert listing([f'n{k}' for k in range(45)]).endswith(', n39 and 5 more')


class Rude(Exception):
    def __str__(self) -> str:
        return NASTY

    __repr__ = __str__


class Mute(Exception):
    def __str__(self) -> str:
        raise RuntimeError('no')

    __repr__ = __str__


@each('error', [Rude(), Rude(1, 2), Mute(), Mute(1, 2), KeyError(NASTY)])
def test_exceptions_are_quoted_whatever_their_text(error: Exception) -> None:
    assert decent(quoted(error), LONGEST + 40) and decent(one_line(error), LONGEST_LINE)
    assert quoted(ZeroDivisionError('by zero')) == "ZeroDivisionError('by zero')"
    assert 'line 3' in quoted(SyntaxError('wrong', ('a.py', 3, 1, 'x = = 1', 3, 9)))


def message(names: list[str], positions: list[float]) -> Any:
    stamp = types.SimpleNamespace(sec=1, nanosec=0)
    header = types.SimpleNamespace(stamp=stamp)
    return types.SimpleNamespace(header=header, name=names, position=positions)


@pytest.mark.parametrize(
    'names', [[NASTY, 'b'], ['a', NASTY], ['a', 'b', 'b'], 100_000 * ['a', 'b']]
)
def test_names_in_messages(names: list[str]) -> None:
    with pytest.raises(MessageError) as caught:
        VectorReader(['a', 'b']).read(message(names, [1.0] * len(names)), 0)
    assert decent(str(caught.value))


@each('labels', [[NASTY], [SHORT_BUT_NASTY], 3000 * ['joint']])
@each('field', ['position[shoulder]', 'velocity', 'name', 'position[99999999]'])
def test_fields_of_messages(labels: list[str], field: str) -> None:
    binding = Binding('y', 'x', 'T', FieldPath.parse(field), 1.0, 0.0, HEADER)
    with pytest.raises(MessageError) as caught:
        FieldReader({0: binding}, 1).read(message(labels, [1.0]), 0)
    assert decent(str(caught.value))


@pytest.mark.parametrize(
    'text', [NASTY, SHORT_BUT_NASTY, f'a.{SHORT_BUT_NASTY}', f'a[{400 * "é"}]b']
)
def test_field_paths(text: str) -> None:
    with pytest.raises(ValueError) as caught:
        FieldPath.parse(text)
    assert decent(str(caught.value))


SPECS = [
    ParameterSpec('word', 'a', 'a word', choices=('a', 'b')),
    ParameterSpec('number', 1.0, 'a number'),
    ParameterSpec('count', 1, 'a count'),
    ParameterSpec('array', (1.0,), 'numbers'),
    ParameterSpec('flag', True, 'a flag'),
    ParameterSpec('words', ('a',), 'words'),
]


@each('value', [NASTY, [NASTY], [1.0, NASTY], 10**5000, [10**5000], [[NASTY]]])
@pytest.mark.parametrize('spec', SPECS, ids=lambda spec: spec.name)
def test_values_of_parameters(spec: ParameterSpec, value: Any) -> None:
    try:
        spec.coerce(value)
    except ValueError as error:
        assert decent(str(error))
    else:
        assert spec.name == 'words' and value == [NASTY]


@each('name', [NASTY, SHORT_BUT_NASTY])
def test_names_of_parameters(name: str) -> None:
    assert decent(ignored([name, *(f'{name}{k}' for k in range(50))], ['a', 'b']), 10_000)
    assert decent(suggest(name, [NASTY, SHORT_BUT_NASTY, 'a']))
    assert decent(suggest('xe31m', [SHORT_BUT_NASTY]))
    tanks = load_model('three_tank')
    values = {spec.name: spec.default for spec in signal_parameters(tanks)}
    for given_name in (f'signals.{name}.topic', f'signals.h1.{name}'):
        with pytest.raises(ValueError) as caught:
            bindings(tanks, values, [given_name])
        assert decent(str(caught.value))
    for choice in ('model', 'observer', 'parameters', 'states'):
        with pytest.raises(ValueError) as caught:
            replay(setup({choice: name if choice in ('model', 'observer') else [name]}), [])
        assert decent(str(caught.value))


def test_a_long_name_is_not_compared_with_everything() -> None:
    """Comparing takes the product of the lengths."""
    assert meant(NASTY, [NASTY]) == '' and meant('gian', ['gain', NASTY]) != ''
    assert decent(suggest(NASTY, [NASTY[:-1] + str(k) for k in range(20)]), 10_000)


@each('stamp', [2**62, -(2**62), 0])
def test_breaks_of_the_timeline(stamp: int) -> None:
    assert decent(describe_break('output', -stamp, stamp))


def failing(text: str) -> Any:
    def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
        raise RuntimeError(text)

    return dynamics


@each('text', [NASTY, SHORT_BUT_NASTY])
def test_a_model_that_raises(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError) as caught:
        Model('m', (Variable('x'),), (Variable('y'),), failing(text), lambda t, x, u, p: (x[0],))
    assert decent(str(caught.value))
    assert 'RuntimeError(' in str(caught.value)


@pytest.mark.parametrize(
    ('body', 'words'),
    [
        (f'raise RuntimeError({NASTY!r})', 'RuntimeError('),
        (f'raise ValueError({NASTY!r})', "'my_bad:M': x"),
        ('import nothing_of_that_name_anywhere', 'is its package installed?'),
        ('raise KeyboardInterrupt', 'KeyboardInterrupt'),
        ('raise SystemExit(3)', 'SystemExit(3)'),
        ('import sys; sys.exit()', 'SystemExit('),
        ('exit(0)', 'SystemExit(0)'),
        (f'setattr(__import__("sys").modules[__name__], {SHORT_BUT_NASTY!r}, 1)', "has no 'M'"),
    ],
    ids=[str(k) for k in range(8)],
)
def test_a_module_that_fails_while_imported(
    body: str, words: str, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / 'my_bad.py').write_text(f'{body}\n', encoding='utf-8', errors='surrogatepass')
    if 'udc80' in body:
        (tmp_path / 'my_bad.py').write_text(f'{body}\n')
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, 'my_bad', raising=False)
    with pytest.raises(ValueError) as caught:
        lookup('model', 'my_bad:M', {})
    assert decent(one_line(caught.value), LONGEST_LINE) and words in str(caught.value)


def test_an_interrupt_while_a_module_is_imported_stays_one(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / 'my_slow.py').write_text(
        'import signal\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n'
        'signal.raise_signal(signal.SIGINT)\nwhile True: pass\n'
    )
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(KeyboardInterrupt):
        lookup('model', 'my_slow:M', {})


@each('separator', [',', ';', '\t'])
def test_columns_and_fields_of_a_table(separator: str, tmp_path: Any) -> None:
    nasty = 'x\x1b[31m\u202e' + 20_000 * 'y'
    path = tmp_path / 'a.csv'
    tanks = load_model('three_tank')
    known = ['t', *(v.name for v in (*tanks.inputs, *tanks.outputs))]
    for header, row in (
        ([nasty, *known], ['1'] * (1 + len(known))), ([nasty, nasty, *known], []),
        ([nasty, *known[:-1]], []), ([nasty, *known], [*['1'] * len(known), nasty]),
        ([*known], [nasty, *['1'] * (len(known) - 1)]),
    ):  # fmt: skip
        lines = (separator.join(header), separator.join(row))
        path.write_text('\n'.join(lines) + '\n')
        try:
            table = Table(path, {}, None, tanks)
            assert all(decent(remark, 10_000) for remark in table.remarks)
            list(table)
        except ValueError as error:
            assert decent(str(error).replace(str(path), ''), 10_000)


@each(
    'text',
    [
        f'{SHORT_BUT_NASTY}: [', f'a: &x {SHORT_BUT_NASTY}', f'"a\\e[31m{1000 * "y"}": 1',
        f'"a\\e[31m": {{ros__parameters: "b\\e[1m{1000 * "y"}"}}',
        f'"a\\e[31m{1000 * "y"}": {{ros__parameters: {{a: 1}}}}',
        f'estimator: {{ros__parameters: {{a: {5000 * "1"}}}}}', f'[{1000 * "[" }',
    ],
)  # fmt: skip
def test_parameter_files(text: str, tmp_path: Any) -> None:
    path = tmp_path / 'a.yaml'
    path.write_text(text)
    with pytest.raises(ValueError) as caught:
        read_parameters(path)
    assert decent(str(caught.value).replace(str(path), ''))


def test_a_seed_of_thousands_of_digits() -> None:
    seed = parse(b'0x' + 5000 * b'f', '-p seed')
    with pytest.raises(ValueError, match=r'^seed must be an integer of 64 bits$'):
        setup({'seed': seed})


def test_a_bag_with_topics_of_any_name(tmp_path: Any) -> None:
    from bags import BagMaker

    with BagMaker(tmp_path / 'bag') as bag:
        bag.vector('/x\x1b[31m' + 1000 * 'y', 0, 0, h1=1.0)
        bag.vector('/plant/outpu\x1b', 0, 0, h1=1.0)
    with pytest.raises(ValueError) as caught:
        Bag(tmp_path / 'bag', Binder('/estimator', {}, {}, 0.1), load_model('three_tank'))
    assert decent(str(caught.value).replace(str(tmp_path), ''))


def test_the_page_of_a_replay() -> None:
    account = replay(setup({}), [])
    account.notes += [SHORT_BUT_NASTY, NASTY]

    class Nothing:
        remarks = (SHORT_BUT_NASTY,)
        refused: dict[str, int] = {}  # noqa: RUF012

    page = summary(NASTY, setup({}), account, Nothing(), deadline=False)  # type: ignore[arg-type]
    assert all(decent(line, 2 * LONGEST_LINE) for line in page.splitlines())


def test_errors_of_a_record_name_the_place_in_one_line() -> None:
    with pytest.raises(ValueError) as caught:
        Record(np.array([0.0, 0.0]), np.zeros((2, 1)), np.zeros((2, 1)))
    assert decent(str(caught.value))
