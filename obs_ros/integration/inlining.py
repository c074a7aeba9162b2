"""Texts of kernels with their helpers written out where they are called.

Numba compiles every function that a kernel calls as a library of its own, once for each type that
an argument passes through while types are sought: some 0.1 s for a line that gathers three numbers,
three quarters of the time that a kernel takes. Written out they compile to the same loops.
"""

import ast
import contextlib
import copy
import itertools
from collections.abc import Iterable, Iterator, Mapping

TRIES = 5  # to parse a text, beside other threads that do
# Of these only parts are evaluated, so that no call may be taken out of them.
CONDITIONAL = (ast.IfExp, ast.BoolOp, ast.Lambda, ast.ListComp, ast.GeneratorExp)


def inlined(text: str) -> str:
    """Return the text of a module in which functions decorated `entry` call none decorated `jit`.

    What nothing calls any more is left out. Those with a `return` elsewhere than at their end are
    called as they were, and so is every one where a condition decides whether it is called.
    """
    tree = parsed(text)
    helpers = {f.name: f for f in functions(tree, 'jit') if is_short(f)}
    for each in tree.body:  # another name of a function
        if isinstance(each, ast.Assign) and isinstance(each.value, ast.Name):
            (target,) = each.targets
            if each.value.id in helpers and isinstance(target, ast.Name):
                helpers[target.id] = helpers[each.value.id]
    written_out = {id(helper) for helper in helpers.values()}
    for decorator in ('entry', 'jit', 'jit_sum'):
        for each in functions(tree, decorator):
            if id(each) not in written_out:
                each.body = _Inliner(helpers).block(each.body)
    tree.body = needed(tree)
    return ast.unparse(ast.fix_missing_locations(tree))


def parsed(text: str) -> ast.Module:
    """Return the syntax tree of a module.

    Of two threads that make one at once Python 3.11 and 3.12 may refuse either (gh-106905).
    """
    for _ in range(TRIES):
        with contextlib.suppress(SystemError):
            return ast.parse(text)
    return ast.parse(text)


def needed(tree: ast.Module) -> list[ast.stmt]:
    """Return a module's statements without the functions, but `entry`, that nothing calls."""
    entries = {each.name for each in functions(tree, 'entry')}
    helpers: dict[str, ast.stmt] = {}
    for each in tree.body:
        if isinstance(each, ast.FunctionDef) and each.name not in entries:
            helpers[each.name] = each
        elif isinstance(each, ast.Assign) and isinstance(each.value, ast.Name):
            helpers[ast.unparse(each.targets[0])] = each  # another name of a function
    left_out = {*map(id, helpers.values())}
    kept = [each for each in tree.body if id(each) not in left_out]
    for each in kept:
        names = {part.id for part in ast.walk(each) if isinstance(part, ast.Name)}
        kept += [helpers.pop(name) for name in names & helpers.keys()]
    found = {*map(id, kept)}
    return [each for each in tree.body if id(each) in found]


def functions(tree: ast.Module, decorator: str) -> Iterator[ast.FunctionDef]:
    """Yield the functions of a module that have just this decorator."""
    for each in tree.body:
        if isinstance(each, ast.FunctionDef) and [*map(ast.unparse, each.decorator_list)] == [
            decorator
        ]:
            yield each


def is_short(function: ast.FunctionDef) -> bool:
    """Whether a function has no loop, and returns at its end only, or nothing."""
    parts = [*ast.walk(function)]
    returns = [each for each in parts if isinstance(each, ast.Return)]
    loops = any(isinstance(each, ast.For | ast.While) for each in parts)
    return not loops and (not returns or returns == function.body[-1:])


class _Inliner:
    """Writes out the calls in one kernel; every call has names of its own for what is local."""

    def __init__(self, helpers: Mapping[str, ast.FunctionDef]) -> None:
        self._helpers = helpers
        self._numbers = itertools.count()

    def block(self, statements: Iterable[ast.stmt]) -> list[ast.stmt]:
        """Return the statements without calls of helpers."""
        found: list[ast.stmt] = []
        for each in statements:
            self._add(each, found)
        return found or [ast.Pass()]

    def _add(self, statement: ast.stmt, found: list[ast.stmt]) -> None:
        """Add a statement, and before it what its calls come to."""
        for name, value in ast.iter_fields(statement):
            if isinstance(value, ast.expr) and not isinstance(statement, ast.While):
                setattr(statement, name, self._value(value, found))
            elif name in ('body', 'orelse') and value:
                setattr(statement, name, self.block(value))
        if not (isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)):
            found.append(statement)

    def _value(self, value: ast.expr, before: list[ast.stmt]) -> ast.expr:
        """Return an expression of what the statements `before` it have computed."""
        if isinstance(value, CONDITIONAL):
            return value
        for name, part in ast.iter_fields(value):
            if isinstance(part, ast.expr):
                setattr(value, name, self._value(part, before))
            elif isinstance(part, list):
                parts = [self._value(p, before) if isinstance(p, ast.expr) else p for p in part]
                setattr(value, name, parts)
        if isinstance(value, ast.Call) and isinstance(value.func, ast.Name):
            helper = self._helpers.get(value.func.id)
            if helper is not None:
                return self._written_out(helper, value.args, before)
        return value

    def _written_out(
        self, helper: ast.FunctionDef, arguments: list[ast.expr], before: list[ast.stmt]
    ) -> ast.expr:
        """Add the statements of a helper, and return its result, None if it has none."""
        number = next(self._numbers)
        body = copy.deepcopy(helper.body)
        stored = {
            each.id for each in ast.walk(helper)
            if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)
        }  # fmt: skip
        names: dict[str, ast.expr] = {name: ast.Name(f'{name}_{number}') for name in stored}
        for parameter, argument in zip(helper.args.args, arguments, strict=True):
            name = parameter.arg
            if isinstance(argument, ast.Name | ast.Constant) and name not in stored:
                names[name] = argument
                continue
            names[name] = ast.Name(f'{name}_{number}')
            target = ast.Name(f'{name}_{number}', ast.Store())
            before.append(ast.Assign([target], argument))
        renamed = [_Renamed(names).visit(each) for each in body]
        if not isinstance(renamed[-1], ast.Return) or renamed[-1].value is None:
            before.extend(self.block(renamed))
            return ast.Constant(None)
        before.extend(self.block(renamed[:-1]) if renamed[:-1] else [])
        result = ast.Name(f'{helper.name}_{number}', ast.Store())
        value = self._value(renamed[-1].value, before)
        before.append(ast.Assign([result], value))
        return ast.Name(result.id, ast.Load())


class _Renamed(ast.NodeTransformer):
    """Puts other expressions in the places of names."""

    def __init__(self, names: Mapping[str, ast.expr]) -> None:
        self._names = names

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id not in self._names:
            return node
        other = copy.copy(self._names[node.id])
        if isinstance(other, ast.Name):
            other.ctx = node.ctx
        return other
