"""The recorder of what a function computes: a list of operations, and the branches taken.

A function called with symbols leaves the list of its operations (a trace; Griewank & Walther 2008,
section 6.1). Equal operations are recorded once. A branch on a value asks the recorder which way to
go: whoever calls the function again with other decisions learns both ways.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

Operand = int | str  # the number of a node, or the text of an argument or a constant


class Untraceable(Exception):
    """A function does something that no list of operations can hold; the text names the cure."""


@dataclass(frozen=True)
class TraceSettings:
    """Limits of a trace, beyond which a function is run candidate by candidate.

    - `paths`: ways through a function with branches, one call for each, recorded in milliseconds;
    - `recorded`: operations on all of these ways; a guard of memory;
    - `operations`: those that are left in the function; some thousands compile in a minute;
    - `table`: entries of a table that `np.interp` looks up, three operations for each;
    - `order`: of a linear system, whose solution takes 2/3 of its cube in operations.
    """

    paths: int = 512
    recorded: int = 200_000
    operations: int = 4000
    table: int = 64
    order: int = 8


LIMITS = TraceSettings()
TOO_MANY = f'use fewer than {LIMITS.operations} operations, or loops of fewer rounds'


@dataclass
class Recorder:
    """Nodes in the order of their recording, each a template and its operands.

    `decisions` are those to take at the conditions that a function branches on, in their order;
    `taken` gets the conditions with what was decided, `True` first where nothing is given.
    """

    nodes: list[tuple[str, tuple[Operand, ...]]] = field(default_factory=list)
    numbers: dict[tuple[str, tuple[Operand, ...]], int] = field(default_factory=dict)
    decisions: Sequence[bool] = ()
    taken: dict[Operand, bool] = field(default_factory=dict)
    paths: int = 1

    def begin(self, decisions: Sequence[bool]) -> None:
        """Make ready for one more call, with these decisions."""
        self.decisions, self.taken = decisions, {}

    def decide(self, condition: Operand) -> bool:
        """Return which way to go; raises Untraceable where there are too many."""
        if condition not in self.taken:
            place = len(self.taken)
            if place < len(self.decisions):
                self.taken[condition] = self.decisions[place]
            elif self.paths >= LIMITS.paths:
                raise Untraceable(
                    'use np.where, or a loop of fixed length, in place of branches on values '
                    f'with more than {LIMITS.paths} ways through them'
                )
            else:
                self.paths += 1
                self.taken[condition] = True
        return self.taken[condition]

    def record(self, template: str, operands: tuple[Operand, ...]) -> int:
        """Return the number of the node that holds an operation."""
        key = template, operands
        if key not in self.numbers:
            if len(self.nodes) >= LIMITS.recorded:
                raise Untraceable(TOO_MANY)
            self.numbers[key] = len(self.nodes)
            self.nodes.append(key)
        return self.numbers[key]

    def merged(self, condition: Operand, chosen: Operand, other: Operand) -> Operand:
        """Return one of two operands by a condition, selected where the ways to them part.

        What both ways compute alike is computed once: where(c, f(a), f(b)) is f(where(c, a, b)).
        """
        alike: list[tuple[str, list[Operand], int]] = []
        while isinstance(chosen, int) and isinstance(other, int) and chosen != other:
            (template, ours), (theirs, others) = self.nodes[chosen], self.nodes[other]
            parted = [i for i, (a, b) in enumerate(zip(ours, others, strict=False)) if a != b]
            if template != theirs or len(parted) != 1:
                break
            alike.append((template, list(ours), parted[0]))
            chosen, other = ours[parted[0]], others[parted[0]]
        found = chosen
        if chosen != other:
            both = _as_float(chosen), _as_float(other)
            found = self.record('np.where({}, {}, {})', (condition, *both))
        for template, operands, place in reversed(alike):
            operands[place] = found
            found = self.record(template, tuple(operands))
        return found


def _as_float(operand: Operand) -> Operand:
    """Return a constant as a float, since a whole number beside another makes arrays of such."""
    if isinstance(operand, str) and (digits := operand.strip('(-)')).isdigit():
        return operand.replace(digits, f'{digits}.0')
    return operand
