"""Message types by name."""

import pytest
from std_msgs.msg import Float64, String

from obs_ros.ros.message_types import fields_of, message_type

FLOAT = 'std_msgs/msg/Float64'


def test_types_are_named_strictly():
    assert message_type(FLOAT) is Float64 and message_type('std_msgs/msg/String') is String
    assert fields_of('std_msgs/Header') == fields_of('std_msgs/msg/Header')


@pytest.mark.parametrize(
    'name',
    [
        '', 'Float64', 'std_msgs/Float64', 'std_msgs/srv/Empty', 'std_msgs.msg/msg/Float64',
        '../msg/A', 'os/msg/Path', 'std_msgs/msg/_float64', 'Std/msg/A', f'{FLOAT}\n',
        'std_msgs/msg/Metaclass_Float64', 'node/msg/Fakes',
    ],
)  # fmt: skip
def test_what_is_no_message_type_is_refused(name):
    with pytest.raises(ValueError):
        message_type(name)
