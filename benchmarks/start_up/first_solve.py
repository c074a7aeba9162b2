"""Solve one stored window, as the first thing a new process does; started by start_up.py."""

import json
import sys
import time

BEGIN = time.perf_counter()

import numpy as np  # noqa: E402

from obs_ros import Record, load_model, solve_window  # noqa: E402
from obs_ros.integration.backends import kernels_for  # noqa: E402


def main(path: str) -> None:
    """Print the seconds that importing, compiling and solving took, and the outcome, as JSON."""
    with np.load(path) as stored:
        record = Record(stored['t'], stored['u'], stored['y'])
    imported = time.perf_counter()
    kernels_for(load_model('three_tank'))
    compiled = time.perf_counter()
    estimate = solve_window('three_tank', record, seed=1)
    solved = time.perf_counter()
    phases = {
        'import': imported - BEGIN,
        'compile': compiled - imported,
        'solve': solved - compiled,
        'outcome': estimate.outcome,
    }
    print(json.dumps(phases), flush=True)


if __name__ == '__main__':
    main(sys.argv[1])
