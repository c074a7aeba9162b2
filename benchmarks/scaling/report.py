"""Tables of the growth."""

from collections.abc import Sequence

from benchmarks.report import filled, table
from benchmarks.scaling.curve import CAUSES, Curve, exponent
from benchmarks.scaling.run import SNR


def report(curves: Sequence[Curve], seeds: Sequence[int], drawn: str) -> str:
    """Return the report, with the picture at its end."""
    tables = (f'## {one.title}\n\n{one.remark}\n\n{table(one.rows)}' for one in curves)
    return filled(
        'scaling/report',
        count=len(seeds),
        first=seeds[0],
        last=seeds[-1],
        snr=SNR,
        summary=summary(curves),
        curves='\n\n'.join(tables),
        pictures=drawn,
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
    return table(rows)
