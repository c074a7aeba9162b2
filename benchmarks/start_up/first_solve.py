"""Solve one stored window, as the first thing a new process does; started by run.py."""

import json
import sys
import time

BEGIN = time.process_time()

import numpy as np  # noqa: E402

from obs_ros import Record, solve_window  # noqa: E402


def main(path: str) -> None:
    """Print the process time (s) that importing and solving took, and the outcome, as JSON."""
    with np.load(path) as stored:
        record = Record(stored['t'], stored['u'], stored['y'])
    imported = time.process_time()
    estimate = solve_window('three_tank', record, seed=1)
    phases = {
        'import': imported - BEGIN,
        'solve': time.process_time() - imported,
        'outcome': estimate.outcome,
    }
    print(json.dumps(phases), flush=True)


if __name__ == '__main__':
    main(sys.argv[1])
