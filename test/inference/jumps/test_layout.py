"""Tests of obs_ros.inference.jumps.layout."""

import numpy as np

from obs_ros.inference.jumps.layout import Layout


class TestLayout:
    def test_without_events(self) -> None:
        layout = Layout(3)
        assert (layout.size, layout.times.tolist(), layout.jumped(np.zeros(3))) == (3, [], [])
        assert layout.final(np.zeros(3)).tolist() == [0, 1, 2]

    def test_places(self) -> None:
        layout = Layout(3, ((1, 2), (1,)))
        assert layout.size == 8
        assert layout.times.tolist() == [3, 6]
        #                 z             time  1    2    time  1
        point = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8])
        assert layout.jumped(point) == [(0, 1, 1, 4), (0, 2, 2, 5), (1, 1, 4, 7)]
        assert layout.final(point).tolist() == [0, 7, 5]

    def test_events_in_order_of_time_whatever_their_place(self) -> None:
        layout = Layout(3, ((1, 2), (1,)))
        point = np.array([0.1, 0.2, 0.3, 0.9, 0.5, 0.6, 0.7, 0.8])
        assert layout.jumped(point) == [(1, 1, 1, 7), (0, 1, 7, 4), (0, 2, 2, 5)]
        assert layout.final(point).tolist() == [0, 4, 5]
