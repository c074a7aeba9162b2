"""Tables of the growth."""

from collections.abc import Sequence

from benchmarks.report import table
from benchmarks.scaling.curve import CAUSES, Curve, exponent
from benchmarks.scaling.run import SNR


def report(curves: Sequence[Curve], seeds: Sequence[int]) -> list[str]:
    """Return the parts of the report."""
    return [
        introduction(seeds),
        summary(curves),
        *(f'## {curve.title}\n\n{curve.remark}\n\n' + table(curve.rows) for curve in curves),
    ]


def introduction(seeds: Sequence[int]) -> str:
    """Say what was done."""
    return (
        f'Medians over {len(seeds)} random windows (seeds {seeds[0]} to {seeds[-1]}), cold start, '
        f'defaults, noise unknown, {SNR:g} dB; process time in one process, compiled before. '
        'A candidate-step is one candidate over one integration step.'
    )


def summary(curves: Sequence[Curve]) -> str:
    """Tell the fitted exponents."""
    rows = []
    for curve in curves:
        whole, upper = curve.exponents
        half = len(curve.x) // 2
        rows.append({
            'cost against': curve.title,
            'range': f'{curve.x[0]:g} to {curve.x[-1]:g}',
            'cost, last / first': f'{curve.seconds[-1] / curve.seconds[0]:.1f}',
            'exponent': f'{whole:.2f}',
            'upper half': f'**{upper:.2f}**',
            **{
                name: f'{exponent(curve.x[half:], curve.causes[name][half:]):.2f}'
                if curve.causes else ''
                for name in CAUSES
            },
        })  # fmt: skip
    return (
        'Exponents of growth: of the process time over all sizes and over the upper half of them; '
        'there also of what it is made of. Linear is 1.\n\n' + table(rows)
    )
