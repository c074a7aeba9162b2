"""Tables 1, 4 and 5: clean sequences, hard ones, and the noise given wrongly."""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.report import slashed, table
from benchmarks.sequence.contestants import OURS
from benchmarks.sequence.scores import (
    after,
    alarmed,
    before,
    confidently_wrong,
    coverage,
    mismatched,
    rms,
    windows,
    withheld,
)
from benchmarks.sequence.track import Cells, Track


def clean_table(cells: Cells) -> str:
    """Tell of every clean cell and contestant."""
    return table(
        {
            'windows': cell,
            'contestant': contestant,
            'number': windows(own),
            'coverage p': coverage(own, 'p'),
            'coverage end state': coverage(own, 'x'),
            'cw': confidently_wrong(own),
            'withheld p / end state': slashed((withheld(own, k).value for k in 'px'), '.3f'),
            'false alarms': f'{alarmed(own).value:.4f}',
            'mismatch': f'{mismatched(own).value:.3f}',
            'RMS error p / end state, % of box': slashed(rms(own, kind) for kind in 'px'),
        }
        for (cell, contestant), own in cells.items()
    )


def suspects(cells: Cells) -> str:
    """List runs of ours with windows that are confidently wrong, or with a false alarm."""
    lines = []
    for (cell, contestant), own in cells.items():
        if contestant != OURS:
            continue
        for what, hits in (
            ('confidently wrong', [track.confidently_wrong.any(axis=1) for track in own]),
            ('false alarm', [track.alarms > 0 for track in own]),
        ):
            told = ', '.join(
                f'{track.scene.seed} (windows ending at '
                + ', '.join(f'{end:g}' for end in track.end[hit])
                + ' s)'
                for track, hit in zip(own, hits, strict=True)
                if hit.any()
            )
            if told:
                lines.append(f'- {cell}, {what}: seed {told}')
    return '\n'.join(lines) or 'None.'


def hard_table(cells: Cells) -> str:
    """Tell of every scene that the windows do not expect, before and after it begins."""
    rows = []
    for (scene, snr), own in cells.items():
        early, late = [before(track) for track in own], [after(track) for track in own]
        calm = windows(early) > 0
        rows.append({
            'what': scene,
            'SNR': snr,
            'windows after': windows(late),
            'cw before': f'{confidently_wrong(early).value:.3f}' if calm else '-',
            'cw after': confidently_wrong(late),
            'coverage p after': coverage(late, 'p'),
            'withheld p after': f'{withheld(late, "p").value:.3f}',
            'mismatch before': f'{mismatched(early).value:.3f}' if calm else '-',
            'mismatch after': mismatched(late),
            'alarms per run after': f'{float(np.mean([t.alarms.sum() for t in late])):.2f}',
        })  # fmt: skip
    return table(rows)


def noise_table(cells: Mapping[tuple[float, bool], Sequence[Track]]) -> str:
    """Tell the effect of a wrong noise, when it may be learned and when not."""
    rows = []
    for (factor, learn), own in cells.items():
        outcomes = Counter(outcome for track in own for outcome in track.outcomes)
        change = {kind: f'{difference(cells, factor, learn, kind):+.3f}' for kind in 'px'}
        rows.append({
            '`learn_noise`': 'on' if learn else 'off',
            'noise given': f'x {factor:g}',
            'windows': windows(own),
            'coverage p': coverage(own, 'p'),
            'coverage end state': coverage(own, 'x'),
            'against x 1, p': change['p'],
            'against x 1, end state': change['x'],
            'cw': confidently_wrong(own),
            'withheld p': f'{withheld(own, "p").value:.3f}',
            'verdicts': ', '.join(
                f'{name} {count / windows(own):.2f}' for name, count in outcomes.most_common()
            ),
        })  # fmt: skip
    return table(rows)


def difference(
    cells: Mapping[tuple[float, bool], Sequence[Track]], factor: float, learn: bool, what: str
) -> float:
    """Return how much the coverage of `p` or end states changes when the noise is given wrongly."""
    value, right = (coverage(cells[f, learn], what).value for f in (factor, 1.0))
    return value - right
