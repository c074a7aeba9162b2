from obs_ros.interface.readers import VectorReader
from obs_ros.ros.messages import named_vector, time_message

STAMP = 1_700_000_000_123_456_789


def test_what_is_written_is_read():
    message = named_vector(STAMP, ('a', 'b'), (1.0, float('nan')))
    stamp, values = VectorReader(('a', 'b')).read(message, 0)
    assert stamp == STAMP
    assert values[0] == 1.0 and values[1] != values[1]
    assert not message.velocity and not message.effort and not message.header.frame_id


def test_further_figures_of_each_name_are_velocities_and_efforts():
    message = named_vector(STAMP, ('a', 'b'), (1.0, 2.0), (3.0, 4.0), (5.0, 6.0))
    assert (list(message.velocity), list(message.effort)) == ([3.0, 4.0], [5.0, 6.0])


def test_stamps_have_seconds_and_nanoseconds():
    stamp = time_message(STAMP)
    assert (stamp.sec, stamp.nanosec) == (1_700_000_000, 123_456_789)
