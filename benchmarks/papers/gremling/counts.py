"""Operations and random numbers of a generation, counted: Gremling & Passino 2000, eqs. 6 to 9.

The genetic algorithm of section 2 written out gene by gene, on numbers that count what is done
with them.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.papers.gremling.plan import MINIMUM
from benchmarks.papers.truth import PERIOD
from obs_ros import load_model
from obs_ros.integration.steps import euler
from plant_sim.scenarios import load_scenario

N, BEST, ELITE, MUTATION, W = 200, 70, 10, 0.2, 50  # section 4.2: N, D, rho D, p_m, W
DIGITS = 5  # of a trait: 1.0000
RANGES = (18000, 23000), (18000, 23000), (8000, 12000), (8000, 12000), (7000, 11000), (6000, 11000)
DONE: Counter[str] = Counter()  # operations on Counted numbers


class Counted(float):
    """A number that counts the additions and multiplications it takes part in."""


def _counting(name: str, kind: str) -> Callable[..., Any]:
    plain = getattr(float, name)

    def operate(*numbers: float) -> Any:
        DONE[kind] += 1
        return Counted(plain(*numbers))

    return operate


for _name in ('__add__', '__radd__', '__sub__', '__rsub__'):
    setattr(Counted, _name, _counting(_name, 'additions'))
for _name in ('__mul__', '__rmul__'):
    setattr(Counted, _name, _counting(_name, 'multiplications'))


def operations() -> tuple[Counter[str], Counter[str]]:
    """Return the additions and multiplications of N fitnesses: eqs. 4-5 alone, and all (eq. 18).

    Of one candidate, N times: every candidate's are the same.
    """
    model = load_model(load_scenario(MINIMUM).model)
    p = tuple(Counted(variable.nominal) for variable in model.parameters)
    x, u, y = tuple(Counted(0.1 * i) for i in range(3)), (Counted(1.0),), Counted(0.5)
    DONE.clear()
    expected = []
    for _ in range(W + 1):
        x = tuple(euler(model.dynamics, 0.0, Counted(PERIOD), (y, *x[1:]), u, u, u, p))
        expected.append(x[0])
    steps = Counter(DONE)
    DONE.clear()
    deviations = [y - one for one in expected]
    squares = [deviation * deviation for deviation in deviations]
    total = squares[0]
    for square in squares[1:]:
        total = total + square
    Counted(1.0) - Counted(0.5) * total
    criterion = Counter(DONE)
    return _times(criterion), _times(criterion + steps)


def _times(one: Counter[str]) -> Counter[str]:
    return Counter({kind: N * count for kind, count in one.items()})


@dataclass
class Dice:
    """Random numbers by what they are for, counted."""

    rng: np.random.Generator
    thrown: Counter[str] = field(default_factory=Counter)

    def whole(self, purpose: str, below: int) -> int:
        """Return a whole number from 0 to below - 1."""
        self.thrown[purpose] += 1
        return int(self.rng.integers(below))

    def unit(self, purpose: str) -> float:
        """Return a number from 0 to 1."""
        self.thrown[purpose] += 1
        return float(self.rng.random())


def draws(generations: int, seed: int) -> list[Counter[str]]:
    """Return what each of so many generations draws, by purpose: eqs. 7-9.

    Strings rank by their distance from the middle of the ranges, so that the population gathers
    there, as it does on a plant.
    """
    dice = Dice(np.random.default_rng(seed))
    population = [[_inside(dice, i) for i in range(len(RANGES))] for _ in range(N)]
    found = []
    for _ in range(generations):
        dice.thrown.clear()
        population.sort(key=_distance)
        population = population[:ELITE] + _children(dice, population[:BEST])
        found.append(Counter(dice.thrown))
    return found


def _children(dice: Dice, best: Sequence[list[int]]) -> list[list[int]]:
    children: list[list[int]] = []
    while len(children) < N - ELITE:
        mother, father = (best[dice.whole('parents', len(best))] for _ in range(2))
        pair: tuple[list[int], list[int]] = ([], [])
        for i, (a, b) in enumerate(zip(mother, father, strict=True)):
            tail = 10 ** (DIGITS - 1 - dice.whole('sites', DIGITS - 1))
            crossed = a - a % tail + b % tail, b - b % tail + a % tail
            for child, value in zip(pair, crossed, strict=True):
                child.append(_mutated(dice, i, value))
        children += pair
    return children


def _mutated(dice: Dice, trait: int, value: int) -> int:
    for digit in range(DIGITS):
        if dice.unit('tests of mutation') < MUTATION:
            unit = 10**digit
            value += (dice.whole('alleles', 10) - value // unit % 10) * unit
    low, high = RANGES[trait]
    return value if low <= value <= high else _inside(dice, trait)


def _inside(dice: Dice, trait: int) -> int:
    low, high = RANGES[trait]
    return low + int(dice.unit('traits out of range') * (high - low + 1))


def _distance(string: Sequence[int]) -> float:
    return sum(abs(value - sum(ends) / 2) for value, ends in zip(string, RANGES, strict=True))
