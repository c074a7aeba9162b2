"""Tests of obs_ros.samples.own_times: delays first, then nodes."""

import numpy as np

from obs_ros.core.typing import Array
from obs_ros.samples.delay_line import Shifts
from obs_ros.samples.merge import Role
from obs_ros.samples.own_times import OwnTimes

MS = 10**6


class Kept:
    """A store that takes everything."""

    passed = None

    def __init__(self) -> None:
        self.samples: list[tuple[str, int]] = []

    def keep(self, role: Role, stamp: int, values: Array) -> bool:
        self.samples.append((role, stamp))
        return True

    def forget(self) -> None:
        self.samples.clear()


def test_without_delays_and_nodes_samples_go_straight_to_the_store() -> None:
    store = Kept()
    times = OwnTimes(store, None, None, {})
    assert times.entrance is store
    assert times.reached({'input': 5, 'output': 7}) == 5
    assert times.earliest('output') == 0


def test_a_delay_leads_to_the_node_at_which_an_output_was_measured() -> None:
    store, counts = Kept(), dict.fromkeys(('off_grid', 'duplicate', 'late'), 0)
    times = OwnTimes(store, Shifts((), (-30 * MS,)), 0.1, counts)
    for k in range(5):
        times.entrance.keep('output', (100 * k + 30 + k % 2) * MS, np.array([1.0]))
    nodes = [stamp // MS for _, stamp in store.samples]
    assert nodes == [0, 100, 200, 300, 400][: len(nodes)] and len(nodes) >= 4
    assert counts['off_grid'] == 0
    assert times.earliest('output') == -30 * MS
    times.clear()
    times.entrance.keep('output', 1080 * MS, np.array([1.0]))
    times.entrance.keep('output', 1180 * MS, np.array([1.0]))
    assert store.samples[-1][1] in (1050 * MS, 1150 * MS)
