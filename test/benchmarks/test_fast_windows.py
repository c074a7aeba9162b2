"""Windows beside their rollouts in C."""

import numpy as np

from benchmarks.fast_windows.__main__ import main as measure
from benchmarks.runner import gcc_version


def test_windows_of_every_kind_are_held_against_their_rollouts(tmp_path):
    rows = measure(['--sequences', '1', '--windows', '6', '--results', str(tmp_path)])
    kinds = ['warm 300', 'warm 1000', 'warm 300, a jump inside', 'cold 1000']
    assert [row.kind for row in rows] == kinds
    for window in (window for row in rows for window in row.windows):
        assert window.steps > 0 and window.seconds > 0.0
        assert (window.ratio > 1.0) == (gcc_version() is not None)
        assert np.isfinite(window.ratio) == (gcc_version() is not None)
    assert 'x its limit' in (tmp_path / 'fast_windows.md').read_text()
