"""Tables 1, 4 and 5: clean sequences, hard ones, and the noise given wrongly."""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from benchmarks.common import table as markdown
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
from benchmarks.sequence.track import Track

Cells = Mapping[tuple[str, str], Sequence[Track]]


def clean_table(cells: Cells) -> str:
    """Tell of every clean cell and contestant."""
    rows = []
    for (cell, contestant), own in cells.items():
        rows.append((
            cell,
            contestant,
            windows(own),
            coverage(own, 'p'),
            coverage(own, 'x'),
            confidently_wrong(own),
            f'{withheld(own, "p").value:.3f} / {withheld(own, "x").value:.3f}',
            f'{alarmed(own).value:.4f}',
            f'{mismatched(own).value:.3f}',
            f'{rms(own, "p"):.2f} / {rms(own, "x"):.2f}',
        ))  # fmt: skip
    head = (
        'windows', 'contestant', 'number', 'coverage p', 'coverage end state', 'cw',
        'withheld p / end state', 'false alarms', 'mismatch', 'RMS error p / end state, % of box',
    )  # fmt: skip
    return markdown(head, rows)


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
        rows.append((
            scene,
            snr,
            windows(late),
            f'{confidently_wrong(early).value:.3f}' if calm else '-',
            confidently_wrong(late),
            coverage(late, 'p'),
            f'{withheld(late, "p").value:.3f}',
            f'{mismatched(early).value:.3f}' if calm else '-',
            mismatched(late),
            f'{float(np.mean([track.alarms.sum() for track in late])):.2f}',
        ))  # fmt: skip
    head = (
        'what', 'SNR', 'windows after', 'cw before', 'cw after', 'coverage p after',
        'withheld p after', 'mismatch before', 'mismatch after', 'alarms per run after',
    )  # fmt: skip
    return markdown(head, rows)


def noise_table(cells: Mapping[tuple[float, bool], Sequence[Track]]) -> str:
    """Tell what a wrong noise does, when it may be learned and when not."""
    rows = []
    for (factor, learn), own in cells.items():
        outcomes = Counter(outcome for track in own for outcome in track.outcomes)
        told = ', '.join(f'{name} {count / windows(own):.2f}' for name, count in sorted(
            outcomes.items(), key=lambda item: -item[1]))  # fmt: skip
        rows.append((
            'on' if learn else 'off',
            f'x {factor:g}',
            windows(own),
            coverage(own, 'p'),
            coverage(own, 'x'),
            *(f'{difference(cells, factor, learn, what):+.3f}' for what in ('p', 'x')),
            confidently_wrong(own),
            f'{withheld(own, "p").value:.3f}',
            told,
        ))  # fmt: skip
    head = (
        '`learn_noise`', 'noise given', 'windows', 'coverage p', 'coverage end state',
        'against x 1, p', 'against x 1, end state', 'cw', 'withheld p', 'verdicts',
    )  # fmt: skip
    return markdown(head, rows)


def difference(
    cells: Mapping[tuple[float, bool], Sequence[Track]], factor: float, learn: bool, what: str
) -> float:
    """Return how much the coverage of `p` or end states changes when the noise is given wrongly."""
    value, right = (coverage(cells[f, learn], what).value for f in (factor, 1.0))
    return value - right
