"""The node's parameters without the node."""

import numpy as np
import pytest
from plants import tank_outputs

from obs_ros import Sample
from obs_ros.replay.engine import replay
from obs_ros.replay.settings import setup


def test_settings_are_checked_by_the_rows_of_the_node():
    chosen = setup({'window.duration': 5, 'use_sim_time': True, 'window.duratoin': 3})
    assert chosen.values['window.duration'] == 5.0
    assert chosen.model.name == 'three_tank'
    (remark,) = chosen.remarks
    assert "'window.duratoin' (did you mean 'window.duration'" in remark
    with pytest.raises(ValueError, match=r'window.duration must be 0.001 to 1e9 s, not -1'):
        setup({'window.duration': -1.0})
    with pytest.raises(ValueError, match=r"no output or input 'h9'"):
        setup({'signals.h9.topic': '/x'})


def test_what_every_node_has_is_no_remark_and_bindings_are_read():
    given = {
        'qos_overrides./plant/output.subscription.depth': 10, 'merge_wait': 2,
        'signals.h1.topic': '/a', 'signals.h1.type': 'std_msgs/msg/Float64',
        'signals.h1.field': 'data', 'signals.h1.stamp': 'arrival',
    }  # fmt: skip
    chosen = setup(given)
    assert chosen.remarks == () and chosen.merge_wait == 2.0
    assert list(chosen.bound) == ['h1'] and chosen.bound['h1'].topic == '/a'


def test_a_replay_leaves_the_checkpoint_of_the_node_alone(tmp_path):
    """With the very file that the node takes."""
    chosen = setup({'checkpoint': str(tmp_path / 'tank'), 'window.duration': 20.0})
    assert chosen.remarks == ()
    levels = tank_outputs(np.arange(42.0), (50.0, 40.0, 45.0), (0.6, 0.5, 0.7))
    stream = [Sample(k * 10**9, y=y, u=[30.0, 30.0]) for k, y in enumerate(levels)]
    assert len(replay(chosen, stream).history) == 2
    assert list(tmp_path.iterdir()) == []
