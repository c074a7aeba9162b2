"""The report on everything measured."""

from benchmarks.report import requirements, table
from benchmarks.sequence import acceptance, cost, information, jumps, rest, tables
from benchmarks.sequence.contestants import CONTESTANTS, EKF, TIKHONOV
from benchmarks.sequence.plants import PLANTS
from benchmarks.sequence.run import Measured
from benchmarks.sequence.scenes import LAG_NOISE


def parts(measured: Measured, seed: int) -> list[str]:
    """Return the report's parts."""
    alone = list(measured.information.values())
    crossings = ', '.join(
        f'{part.crossing.mean():.1%} at {snr:g} dB' for snr, part in measured.information.items()
    )
    return [
        introduction(seed),
        '## Acceptance\n\n' + requirements(acceptance.asked(measured)),
        '## 1. Clean sequences\n\n' + CLEAN + '\n\n' + tables.clean_table(measured.clean),
        '### Ours confidently wrong, or alarmed though nothing jumped\n\n'
        + tables.suspects(measured.clean),
        '## 2. Rest\n\n' + REST + '\n\n' + rest.table(measured.rest),
        '## 3. Jumps\n\n' + JUMPS + '\n\n' + jumps.table(measured.jumps),
        '### Not found in time, or not rightly: seeds (and sizes)\n\n'
        + jumps.missed(measured.jumps),
        '## 4. What the windows do not expect\n\n' + HARD + '\n\n'
        + tables.hard_table(measured.hard),
        '## 5. The noise given wrongly\n\n' + NOISE + '\n\n' + tables.noise_table(measured.noise),
        f'## 6. Windows alone\n\n{len(alone[0].error)} windows at each SNR; ' + ALONE
        + f' Levels cross in {crossings} of them.\n\n### Coverage\n\n'
        + information.coverage_table(measured.information)
        + '\n\n### RMSE over the Cramér-Rao bound\n\n'
        + information.efficiency_table(measured.information),
        '## 7. Cost\n\n' + COST + '\n\n' + cost.table(measured.cost),
    ]  # fmt: skip


def introduction(seed: int) -> str:
    """Say what was done."""
    rows = [
        {
            'plant': name,
            'sample': f'{plant.step:g} s',
            'window': f'{plant.duration:g} s',
            'every': f'{plant.period:g} s, or abutting',
            'inputs': f'stepped at random every {plant.hold:g} s',
            'noise': f'{LAG_NOISE:g}' if name == 'lag' else '1 cm at 0 dB, a tenth every 20 dB',
        }
        for name, plant in PLANTS.items()
    ]
    return (
        f'Runs have the seeds {seed}, {seed + 1} and so on in every cell; a seed draws other runs '
        'for other scenes, and the same run for all contestants and SNRs. Parameters and initial '
        'states are drawn anew for every run. Ours is not told the noise, unless a table says so; '
        'all other contestants know it.\n\n' + table(rows) + '\n\n'
        'Coverage: share of the 95 % intervals (1.96 sd) that hold the truth, among those given. '
        '± is the half-width of the 95 % interval of a share, by the number of windows or by the '
        'spread between runs, whichever is larger. cw, confidently wrong: share of windows in '
        'which the error of a parameter or an end state is above both 3 sd and 2 % of its box, '
        'though a standard deviation was given. Withheld: no standard deviation was given, as the '
        'value is not determined (sd above a tenth of the box) or the window is not explained. '
        'Alarm: a jump reported as new. Mismatch: the outcome `model_mismatch`.'
    )


CLEAN = (
    'Nothing happens but that the inputs step. `no prior`: every window alone. `Tikhonov`: '
    f'every parameter pulled to its previous estimate with a standard deviation of {TIKHONOV:g} '
    'box. `MAP arrival cost`: the prior is the covariance of the window just before, with the same '
    'random walk as ours: overlapping samples are counted twice. '
    + (
        '`EKF`: the extended Kalman filter on states and parameters with its own settings, looked '
        'at when a window ends; its first windows are those in which it starts.'
        if EKF in CONTESTANTS
        else 'This version has no extended Kalman filter to compare with.'
    )
)
REST = (
    'After three windows of excitation all inputs stay constant; told of the windows that lie '
    'wholly in this rest. Drift: the last estimate of a parameter less the first, of the parameter '
    'of a run that drifts most; in boxes, and in the standard deviation last published when the '
    'first of these windows was solved. A step goes from one window to the next, in the standard '
    'deviation last published before it. The last column is the share of standard deviations '
    'suddenly far smaller than in the rest of the run: nothing happens that could tell so much. '
    '`Q1 = 0`: nothing flows between the tanks once they are '
    'level, so that p1 and p3 have no influence any more.'
)
JUMPS = (
    'One parameter jumps, at any time, by .03 to .4 of its box (a third of the runs in each class '
    'of sizes). In time: in the first window that holds at least one period of samples (tanks '
    '50 s, lag 5 s) after the jump, or before. Right set: that window reports one jump, of that '
    'parameter alone. Errors are those of that report. Windows: until the alarm, 1 = the first '
    'that holds a sample after the jump. Further alarms: new jumps reported after the first.'
)
HARD = (
    'Tanks, windows every 50 s. Before and after: windows that end before or after it begins; '
    'outliers (a tenth of the samples has ten times the noise) and wrong areas are there from the '
    'start. The truth of a ramp is its value at the end of the window. Two jumps follow each other '
    'within 100 s. A true pipe area 10 % larger than the model says is invisible by design: '
    'openings 10 % larger have the same outputs, so nothing but knowledge of the pipes could tell; '
    'its coverage is against the true openings. A true tank area 10 % larger is also a wrong '
    'effect of the feeds, which shows when they step.'
)
NOISE = (
    'Tanks, 20 dB, windows every 50 s: the same runs with the noise given rightly and wrongly, and '
    '`learn_noise` on and off.'
)
ALONE = (
    'solved by `solve_window`, noise not given; openings 0.3 to 0.9, levels 15 to 85 cm, 300 '
    'samples 1 s apart. The bound is computed at the truth, with the true noise. Where two levels '
    'cross, the square root in the flow has a kink: the model is not differentiable there, and 1 s '
    'steps of integration err by some 0.003 cm.'
)
COST = (
    'Medians of process times in ms of the same warm windows, solved in all ways in turn, in one '
    'process. Ratios are medians of the ratio of each window. `without`: jump search or informed '
    'subspace is put out of action; prior, noise, tests and standard deviations stay.'
)
