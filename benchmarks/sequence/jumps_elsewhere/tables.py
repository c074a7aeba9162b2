"""Tables of jumps, and of what was taken for one, on plants that nobody has tuned to."""

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from benchmarks.report import quantiles, slashed, table
from benchmarks.sequence.jumps_elsewhere import scores
from benchmarks.sequence.jumps_elsewhere.follow import FARTHEST
from benchmarks.sequence.jumps_elsewhere.judged import (
    How,
    Verdict,
    after,
    announcements,
    calm,
    false_jumps,
    verdicts,
)
from benchmarks.sequence.jumps_elsewhere.rates import clustered
from benchmarks.sequence.jumps_elsewhere.run import EXCITATIONS, Cells
from benchmarks.sequence.jumps_elsewhere.scenes import CLEAN, JUMP, KINDS, PLANTS
from obs_ros.core.typing import BoolArray

BINS = (0.0, 0.5, 0.8, 0.9, 0.95, 1.0 + 1e-9)  # of probabilities
AFTER_FALSE = 'a false jump'


def pooled(cells: Cells, kinds: Sequence[str], rich: bool | None = None) -> scores.Runs:
    """Return the runs of some kinds on all plants, of one excitation or of both."""
    return [
        run
        for cell, runs in cells.items()
        if cell.kind in kinds and rich in (None, cell.rich)
        for run in runs
    ]


def jumps_table(cells: Cells) -> str:
    """Tell how jumps were announced, and what the windows after that published."""
    rows = []
    for rich, excitation in (*EXCITATIONS.items(), (None, 'both')):
        runs = pooled(cells, [JUMP], rich)
        found = [verdict for run in runs for verdict in verdicts(run)]
        for how in How:
            own = [verdict for verdict in found if verdict.how is how]
            rows.append({
                'excitation': excitation,
                'announced': how.value,
                'jumps': f'{len(own)} of {len(found)}',
                **_announced(own),
                **_published(runs, lambda run, how=how: after(run, [how])),
            })  # fmt: skip
        calm_runs = pooled(cells, [CLEAN, JUMP], rich)
        alarms = sum(bool(own) for run in calm_runs for own in [_false_when_calm(run)])
        rows.append({
            'excitation': excitation,
            'announced': AFTER_FALSE,
            'jumps': f'{alarms} runs',
            **_announced([]),
            **_published(calm_runs, _after_false),
        })  # fmt: skip
    return table(rows)


def _announced(own: Sequence[Verdict]) -> dict[str, object]:
    named = [verdict for verdict in own if verdict.how is not How.MISSED]
    errors = [verdict.time_error for verdict in named]
    return {
        'late': sum(verdict.late for verdict in named) if named else '-',
        'mended later': sum(verdict.mended for verdict in named) if named else '-',
        'taken back': sum(verdict.back for verdict in named) if named else '-',
        'time error, s: median / 95 %': slashed(quantiles(errors), '.3g') if errors else '-',
    }


def _published(runs: scores.Runs, chosen: scores.Chosen) -> dict[str, object]:
    return {
        'accepted windows after': scores.count(runs, chosen),
        'any error > 3 sd': scores.beyond(runs, scores.FAR, chosen),
        '> 5 sd': scores.beyond(runs, FARTHEST, chosen),
        '95 % coverage': scores.coverage(runs, chosen),
        'by process noise': scores.pushed(runs, chosen),
    }


def _false_when_calm(run: scores.Followed) -> list[int]:
    mask = calm(run)
    return [each.window for each in false_jumps(run) if mask[each.window]]


def _after_false(run: scores.Followed) -> BoolArray:
    """Choose the windows (W,) after a false jump, before a true one."""
    chosen = np.zeros(len(run.end), dtype=np.bool_)
    for window in _false_when_calm(run):
        chosen[window:] = True
    return chosen & calm(run)


def plants_table(cells: Cells) -> str:
    """Tell of every plant how its jumps were announced."""
    rows = []
    for plant in PLANTS:
        for rich, excitation in EXCITATIONS.items():
            runs = [r for c, own in cells.items() if c == (plant, JUMP, rich) for r in own]
            found = [verdict for run in runs for verdict in verdicts(run)]
            counts = Counter(verdict.how for verdict in found)
            rows.append({
                'plant': plant,
                'excitation': excitation,
                'jumps': len(found),
                **{how.value: counts[how] for how in How},
                'late': sum(verdict.late for verdict in found),
                'further, near no jump': sum(len(false_jumps(run)) for run in runs),
                'a mark of doubt': _doubted(runs),
            })  # fmt: skip
    return table(rows)


def _doubted(runs: scores.Runs) -> str:
    """Tell how many announcements, right and wrong ones, have alternatives."""
    told = {True: [0, 0], False: [0, 0]}
    for run in runs:
        for each in announcements(run):
            told[each.right][0] += bool(each.said.alternatives)
            told[each.right][1] += 1
    return ', '.join(
        f'{told[right][0]} of {told[right][1]} {word}'
        for right, word in ((True, 'right'), (False, 'wrong'))
    )


def calibration_table(cells: Cells) -> str:
    """Tell how many announcements were right, by their probability, in all exact runs."""
    rows = []
    runs = pooled(cells, [CLEAN, JUMP])
    bins: list[tuple[str, float, float]] = [
        (f'{low:g} to {min(high, 1.0):g}', low, high) for low, high in pairwise(BINS)
    ]
    for label, low, high in [('not given', np.nan, np.nan), *bins]:
        own = [
            [each for each in announcements(run) if _inside(each.said.probability, low, high)]
            for run in runs
        ]
        told = [each for every in own for each in every]
        known = [each.said.probability for each in told]
        rows.append({
            'probability': label,
            'announced': len(told),
            'right': clustered([(sum(e.right for e in each), len(each)) for each in own]),
            'mean probability': f'{np.mean(known):.3f}' if told and low == low else '-',
            'taken back, right ones': sum(e.back >= 0 for e in told if e.right),
            'taken back, wrong ones': sum(e.back >= 0 for e in told if not e.right),
        })  # fmt: skip
    return table(rows)


def _inside(probability: float, low: float, high: float) -> bool:
    if np.isnan(low):
        return bool(np.isnan(probability))
    return low <= probability < high


def coverage_table(cells: Cells) -> str:
    """Tell of every cell with and without jumps what was published."""
    rows = []
    for (plant, kind, rich), runs in cells.items():
        if kind in (CLEAN, JUMP):
            rows.append({
                'plant': plant,
                'excitation': EXCITATIONS[rich],
                'runs': kind,
                'windows': sum(len(run.end) for run in runs),
                'accepted': scores.count(runs),
                'coverage p': scores.coverage(runs, what='p'),
                'coverage end state': scores.coverage(runs, what='x'),
                'any error > 3 sd': scores.beyond(runs, scores.FAR),
                '> 5 sd': scores.beyond(runs, FARTHEST),
                'withheld': f'{scores.withheld(runs).value:.3f}',
                'median sd, RMS error where sure, % of box': slashed(_sharp(runs), '.3f'),
            })  # fmt: skip
    return table(rows)


def _sharp(runs: scores.Runs) -> tuple[float, float]:
    masks = [scores.given(run, scores.sure) for run in runs]
    sd = np.concatenate([run.deviations[mask] for run, mask in zip(runs, masks, strict=True)])
    error = np.concatenate([run.error[mask] for run, mask in zip(runs, masks, strict=True)])
    if not sd.size:
        return np.nan, np.nan
    return 100.0 * float(np.median(sd)), 100.0 * float(np.sqrt(np.mean(error**2)))


def false_table(cells: Cells) -> str:
    """Tell of every kind how many windows announce a jump where nothing has jumped."""
    rows = []
    for kind in KINDS:
        runs = pooled(cells, [kind])
        own = [_new(run) for run in runs]
        rows.append({
            'runs': kind,
            'windows': sum(int(calm(run).sum()) for run in runs),
            'that announce a jump': scores.alarmed(runs),
            **{
                plant: f'{scores.alarmed(_of(cells, plant, kind)).value:.4f}' for plant in PLANTS
            },
            'jumps announced': sum(own),
            'most in a run': max(own, default=0),
            'taken back': sum(
                each.back >= 0 for run in runs for each in announcements(run)
                if calm(run)[each.window]
            ),
            'runs told as drifting': _drifting(runs),
            'accepted windows': scores.count(runs),
            'coverage': scores.coverage(runs),
            'any error > 5 sd': scores.beyond(runs, FARTHEST),
        })  # fmt: skip
    return table(rows)


def _of(cells: Cells, plant: str, kind: str) -> scores.Runs:
    return [run for cell, own in cells.items() if cell[:2] == (plant, kind) for run in own]


def _new(run: scores.Followed) -> int:
    mask = calm(run)
    return sum(bool(mask[each.window]) for each in announcements(run))


def _drifting(runs: scores.Runs) -> str:
    """Tell in how many runs a parameter is said to drift, and in how many the one that moves."""
    told = [{name for names in run.drifting for name in names} for run in runs]
    right = sum(run.moving in names for run, names in zip(runs, told, strict=True))
    return f'{sum(map(bool, told))}, {right} rightly' if any(told) else '0'


def cost_table(ratios: Mapping[str, tuple[int, tuple[float, float, float]]]) -> str:
    """Tell the ratios of process times of so many windows."""
    return table(
        {'windows': label, 'number': number, 'ratio': '{:.3f} ({:.3f}-{:.3f})'.format(*ratio)}
        for label, (number, ratio) in ratios.items()
    )
