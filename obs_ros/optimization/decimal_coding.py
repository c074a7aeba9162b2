"""Numbers as strings of decimal digits, on which genetic operators work.

Porter & Passino 1995 (section 2) and Gremling & Passino 2000 (section 2). A chromosome has one
trait for each number; a trait is a sign gene and `digits` genes of 0 to 9, with the decimal point
at a place of its own. Genes are arrays (N, T, 1 + digits) of int8, gene 0 of a trait is its sign
(1 = minus); where a trait cannot be negative the sign stays 0 and takes no part in anything.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from obs_ros.core.jit import accelerated
from obs_ros.core.typing import Array, BoolArray, IntArray

Genes = NDArray[np.int8]

TEN = np.uint64(10)
MOST_DIGITS = 15  # that a float64 holds
ROUNDING = 4.0 * float(np.finfo(np.float64).eps)  # of a product, relative


@dataclass(frozen=True, eq=False)
class Base10:
    """The writing of T traits, each in its range.

    lower, upper (T,) in the traits' units; lowest, highest (T,) are the same ends as whole numbers
    of the last digit, of which `scale` (T,) make one unit; signed (T,) says who has a sign gene.
    """

    lower: Array
    upper: Array
    digits: int
    scale: Array
    lowest: IntArray
    highest: IntArray
    signed: BoolArray

    @classmethod
    def of(
        cls,
        lower: ArrayLike,
        upper: ArrayLike,
        digits: int,
        signed: bool | None = None,
        fewest_values: int = 1000,
    ) -> 'Base10':
        """Write numbers between lower and upper (T,) with at least `digits` digits.

        There is one digit or more before the point where a range reaches 0.1, and as many as the
        largest number in it needs; below 0.1 the first digit is the largest number's. All traits
        get more digits where those of one could write less than `fewest_values` numbers of its
        range. `signed` None gives a sign gene to the ranges with negative numbers.

        Raises ValueError for ranges that are not finite, crossed, or too narrow for 15 digits, and
        for fewer than one digit.
        """
        low, high = np.atleast_1d(np.asarray(lower, float)), np.atleast_1d(np.asarray(upper, float))
        if low.shape != high.shape or low.ndim != 1 or not low.size:
            raise ValueError(f'lower {low} and upper {high} must be of one length')
        if not (np.isfinite(low).all() and np.isfinite(high).all() and (low < high).all()):
            raise ValueError(f'ranges must be finite and rising, not from {low} to {high}')
        if isinstance(digits, bool) or not isinstance(digits, int) or digits < 1:
            raise ValueError(f'digits must be an integer >= 1, not {digits!r}')
        largest = np.maximum(np.abs(low), np.abs(high))
        before = np.floor(np.log10(largest)).astype(np.int64) + 1
        before = np.where(largest >= 0.1, np.maximum(before, 1), before)
        after = np.ceil(np.log10(fewest_values / (high - low))).astype(np.int64)
        needed = max(digits, int((before + after).max()))
        if needed > MOST_DIGITS:
            i = int((before + after).argmax())
            raise ValueError(
                f'the range from {low[i]} to {high[i]} is too narrow for {MOST_DIGITS} digits'
            )
        scale = 10.0 ** (needed - before)
        most = 10**needed - 1  # a bound just below a power of ten is rounded to one digit more
        return cls(
            lower=low,
            upper=high,
            digits=needed,
            scale=scale,
            lowest=np.maximum(-_floor(-low * scale), -most),
            highest=np.minimum(_floor(high * scale), most),
            signed=low < 0.0 if signed is None else np.full(low.size, signed or (low < 0.0)),
        )

    def encode(self, values: Array) -> Genes:
        """Write values (N, T), rounded to the last digit and moved into their ranges."""
        if np.isnan(values).any():
            raise ValueError(f'NaN cannot be written in digits: {values}')
        whole = np.clip(np.rint(values * self.scale), self.lowest, self.highest)
        return digits_of(whole.astype(np.int64), self.digits)

    def decode(self, genes: Genes) -> Array:
        """Read values (N, T) of chromosomes that are inside."""
        return self.values(whole_numbers(genes))

    def values(self, whole: IntArray) -> Array:
        """Return the values (N, T) of whole numbers of the last digit that are inside."""
        return np.minimum(np.maximum(whole / self.scale, self.lower), self.upper)

    def first_population(self, draws: Array) -> Genes:
        """Return chromosomes uniform in their ranges from draws (N, T) uniform on [0, 1)."""
        whole = self.lowest + (draws * (self.highest - self.lowest + 1)).astype(np.int64)
        return digits_of(whole, self.digits)


def whole_numbers(genes: Genes) -> IntArray:
    """Read traits (N, T) as whole numbers of their last digit."""
    whole = genes[:, :, 1].astype(np.int64)
    for digit in range(2, genes.shape[2]):
        whole = 10 * whole + genes[:, :, digit]
    return np.where(genes[:, :, 0] == 1, -whole, whole)


def digits_of(whole: IntArray, digits: int) -> Genes:
    """Write whole numbers (N, T) of the last digit as genes (N, T, 1 + digits)."""
    genes = np.empty((*whole.shape, 1 + digits), dtype=np.int8)
    genes[:, :, 0] = whole < 0
    rest = np.abs(whole)
    for digit in range(digits, 0, -1):
        rest, genes[:, :, digit] = np.divmod(rest, 10)
    return genes


@accelerated
def whole_number(trait: Genes) -> int:
    """Read one trait (G,), as `whole_numbers` does many."""
    whole = 0
    for digit in range(1, len(trait)):
        whole = 10 * whole + int(trait[digit])
    return -whole if trait[0] == 1 else whole


@accelerated
def write_digits(whole: int, trait: Genes) -> None:
    """Write a whole number to the genes of a trait (G,), as `digits_of` does many."""
    trait[0] = 1 if whole < 0 else 0
    rest = np.uint64(abs(whole))  # divided faster than a number with a sign
    for digit in range(len(trait) - 1, 0, -1):
        tens = rest // TEN
        trait[digit] = np.int8(rest - tens * TEN)
        rest = tens


def _floor(exact: Array) -> IntArray:
    """Round down, but not past a whole number that only rounding has missed."""
    nearest = np.rint(exact)
    missed = np.abs(nearest - exact) <= ROUNDING * np.maximum(np.abs(exact), 1.0)
    return np.asarray(np.where(missed, nearest, np.floor(exact)), dtype=np.int64)
