"""A study of 40 recordings by 5 variants on two processes of Dask, beside two bare processes.

The speed-up of each over one process in the same run; bits; a worker killed, a study stopped.
"""

import tempfile
from pathlib import Path

from benchmarks.report import filled, publish, requirements, versions
from benchmarks.runner import options
from benchmarks.studies.report import acceptance, times
from benchmarks.studies.run import DURATIONS, SNR_DB, made, measured


def main(arguments: list[str] | None = None) -> str:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--recordings', type=int, default=40)
    parser.add_argument('--samples', type=int, default=3000, help='of each recording')
    parser.add_argument('--rounds', type=int, default=3, help='of every way')
    parser.add_argument('--seed', type=int, default=190_000, help='of the first recording')
    chosen = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        plan = made(Path(folder), chosen.recordings, chosen.samples, chosen.seed)
        found = measured(plan, chosen.rounds)
    text = filled(
        'studies/report',
        recordings=chosen.recordings,
        samples=chosen.samples,
        snr_db=SNR_DB,
        seed=chosen.seed,
        variants=len(DURATIONS),
        runs=plan.runs,
        rounds=chosen.rounds,
        acceptance=requirements(acceptance(found)),
        times=times(found),
    )
    machine = versions(('distributed',))
    return publish(chosen.results, 'studies', 'Studies on several processes', text, *machine)


if __name__ == '__main__':
    main()
