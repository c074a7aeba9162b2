import array

import pytest
from sensor_msgs.msg import JointState

from obs_ros.interface.field_path import MessageError
from obs_ros.interface.readers import VectorReader
from obs_ros.ros.messages import named_vector

STAMP = 1_700_000_000_123_456_789


def test_what_is_written_is_read():
    message = named_vector(STAMP, ('a', 'b'), (1.0, float('nan')))
    stamp, values = VectorReader(('a', 'b')).read(message, 0)
    assert stamp == STAMP
    assert values[0] == 1.0 and values[1] != values[1]
    assert not message.velocity and not message.effort and not message.header.frame_id


def test_order_is_by_name():
    message = named_vector(0, ('c', 'a', 'b'), (3.0, 1.0, 2.0))
    assert VectorReader(('a', 'b', 'c')).read(message, 0)[1].tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    ('names', 'values', 'reason', 'text'),
    [
        (['a'], [1.0], 'missing_name', "'b' is missing"),
        (['a', 'bb'], [1.0, 2.0], 'unknown_name', "unknown name 'bb'"),
        (['a', 'b'], [1.0], 'wrong_length', '2 names but 1 positions'),
        (['a', 'b', 'a'], [1.0, 2.0, 3.0], 'wrong_length', 'twice'),
        ([], [], 'missing_name', "'a' is missing"),
    ],
)
def test_wrong_messages_say_why(names, values, reason, text):
    message = JointState(name=names, position=array.array('d', values))
    with pytest.raises(MessageError, match=text) as caught:
        VectorReader(('a', 'b')).read(message, 0)
    assert caught.value.reason == reason


def test_values_outlive_their_message():
    message = named_vector(0, ('a',), (1.0,))
    values = VectorReader(('a',)).read(message, 0)[1]
    message.position[0] = 2.0
    assert values.tolist() == [1.0]
