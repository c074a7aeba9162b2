"""A model to begin with: each output follows the inputs as a first-order lag.

    y' = (rest + sum over the inputs of gain (u - usual) - y) / lag

Rest, gains and lag are unknown; bounds and nominal values come from the ranges of the signals. It
is a start that runs and can be estimated, no statement on the plant: its user replaces it.
"""

import math
from dataclasses import dataclass

from obs_ros.cli.model_motion import rounded
from obs_ros.cli.package_signals import Signal, Signals
from obs_ros.cli.recorded_ranges import SHORTEST, Range, Ranges

ROOM = 0.5  # of a span that a state may leave its range by
REACH = 2.0  # spans that a rest may be off
LARGEST_GAIN = 5.0  # spans of the output for one of the input
SAMPLES = 50.0  # in a window, at least
SHARE = 10.0  # windows in a recording
LAGS = 20.0  # nominal lags in a window
LONGEST_LAG = 3.0  # windows
NOISE = 0.01  # spans, of the scenario
WIDTH = 100  # characters


@dataclass(frozen=True)
class Guess:
    """The numbers of a first guess for these signals; times in s."""

    signals: Signals
    ranges: Ranges

    @property
    def window(self) -> float:
        """Length of a window: a tenth of the recording, or 50 samples; at most about half."""
        ranges = self.ranges
        long = max(ranges.duration / SHARE, SAMPLES * ranges.period, 0.5 * SHORTEST)
        return rounded(min(long, 0.5 * ranges.duration))

    @property
    def period(self) -> float:
        """Time from sample to sample, of three digits."""
        return float(f'{self.ranges.period:.3g}')

    def texts(self) -> dict[str, str]:
        """Return the pieces of Python and of the parameter file, by the templates' names."""
        inputs, outputs = self.signals.inputs, self.signals.outputs
        rows = list(zip(outputs, self.ranges.outputs, strict=True))
        return {
            'states': _rows([self._state(signal, extent) for signal, extent in rows]),
            'inputs': _rows([
                f"Variable({s.name!r}, {s.unit!r}, nominal={_number(_usual(r))})"
                for s, r in zip(inputs, self.ranges.inputs, strict=True)
            ]),
            'outputs': _rows([f'Variable({s.name!r}, {s.unit!r})' for s in outputs]),
            'parameters': _rows([p for signal, extent in rows for p in self._lag(signal, extent)]),
            'x_tuple': _tuple([s.name for s in outputs]),
            'x_names': _target([s.name for s in outputs]),
            'u_unpacked': f'    {_target([s.name for s in inputs])} = u\n' if inputs else '',
            'p_names': _target(list(self.signals.parameters)),
            'rates': _rows([self._rate(signal) for signal in outputs], indent=8),
            'moves': _rows(self._moves(), indent=4) if inputs else '()',
            'window': _number(self.window),
            'period': _number(self.period),
            'duration': _number(10.0 * self.window),
            'noise': _number(self.noise),
            'first_output': outputs[0].name,
        }  # fmt: skip

    @property
    def noise(self) -> float:
        """Standard deviation of the scenario's noise: a hundredth of the smallest span."""
        return float(f'{NOISE * min(r.span for r in self.ranges.outputs):.2g}')

    def _state(self, signal: Signal, extent: Range) -> str:
        low, high = _bounds(extent, ROOM)
        start = _near(extent.low + 0.25 * (extent.high - extent.low), extent.span)
        return (f'Variable({signal.name!r}, {signal.unit!r}, lower={_number(low)}, '
                f'upper={_number(high)}, nominal={_number(start)})')  # fmt: skip

    def _lag(self, signal: Signal, extent: Range) -> list[str]:
        """Return the rest, the gains and the lag of an output, as variables."""
        low, high = _bounds(extent, REACH)
        rest = f"Variable('rest_{signal.name}', {signal.unit!r}, lower={_number(low)}, " \
            f'upper={_number(high)}, nominal={_number(_usual(extent))})'  # fmt: skip
        gains = []
        for each, moved in zip(self.signals.inputs, self.ranges.inputs, strict=True):
            size = rounded(extent.span / moved.span)
            most = _number(rounded(LARGEST_GAIN * size))
            unit = _ratio(signal.unit, each.unit)
            gains.append(
                f"Variable('gain_{signal.name}_{each.name}', {unit!r}, lower=-{most}, "
                f'upper={most}, nominal={_number(size)})'
            )
        shortest = rounded(0.5 * self.period)
        usual = max(rounded(self.window / LAGS), rounded(self.period))
        longest = rounded(LONGEST_LAG * self.window)
        lag = (f"Variable('lag_{signal.name}', 's', lower={_number(shortest)}, "
               f"upper={_number(longest)}, nominal={_number(usual)}, scale='log')")  # fmt: skip
        return [rest, *gains, lag]

    def _rate(self, signal: Signal) -> str:
        """Return the rate of an output, as an expression."""
        terms = [f'rest_{signal.name}']
        for each, moved in zip(self.signals.inputs, self.ranges.inputs, strict=True):
            usual = _usual(moved)
            off = f'({each.name} - {_number(usual)})' if usual > 0.0 else each.name
            off = f'({each.name} + {_number(-usual)})' if usual < 0.0 else off
            terms.append(f'gain_{signal.name}_{each.name} * {off}')
        joined = f'({" + ".join(terms)} - {signal.name}) / lag_{signal.name}'
        if len(joined) + 9 <= WIDTH:
            return joined
        inner = '\n            + '.join(terms)
        return f'(\n            {inner}\n            - {signal.name}\n        ) / lag_{signal.name}'

    def _moves(self) -> list[str]:
        """Return how the scenario moves each input: usual value, size, and s from low to high."""
        return [
            f'({_number(_usual(r))}, {_number(rounded(0.25 * r.span))}, '
            f'{_number(rounded(self.window / (4 + 3 * k)))})'
            for k, r in enumerate(self.ranges.inputs)
        ]


def _bounds(extent: Range, share: float) -> tuple[float, float]:
    """Return round bounds wider than a range by a share of its span on each side."""
    step = _step(extent.span)
    low = math.floor((extent.low - share * extent.span) / step) * step
    high = math.ceil((extent.high + share * extent.span) / step) * step
    return low, high


def _near(value: float, span: float) -> float:
    """Return a value rounded to a hundredth of the span's power of ten."""
    step = _step(span)
    return round(value / step) * step


def _step(span: float) -> float:
    """Return a tenth of the span's power of ten."""
    return float(10.0 ** (math.floor(math.log10(span)) - 1))


def _usual(extent: Range) -> float:
    return _near(extent.mean, extent.span)


def _number(value: float) -> str:
    """Return a number without the digits that rounding leaves behind."""
    return repr(float(f'{value:.12g}') + 0.0)


def _ratio(unit: str, per: str) -> str:
    if per == '1':
        return unit
    below = per if per.isalnum() else f'({per})'
    return f'{unit}/{below}'


def _target(names: list[str]) -> str:
    """Return what a tuple is unpacked to, on one line or on one for each."""
    one = f'({names[0]},)' if len(names) == 1 else ', '.join(names)
    if len(one) + 8 <= WIDTH:
        return one
    return '(\n' + ''.join(f'        {name},\n' for name in names) + '    )'


def _tuple(names: list[str]) -> str:
    """Return a tuple, on one line or with one name on each."""
    one = f'({", ".join(names)}{"," if len(names) == 1 else ""})'
    return one if len(one) < 80 else _rows(names)


def _rows(entries: list[str], indent: int = 8) -> str:
    """Return a tuple with one entry on each line."""
    if not entries:
        return '()'
    space = ' ' * indent
    inner = ''.join(f'{space}{entry},\n' for entry in entries)
    return f'(\n{inner}{" " * (indent - 4)})'
