"""Tests of obs_ros.interface.field_path."""

import array
import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from obs_ros.interface.field_path import LABELS, FieldPath, MessageError, Step


@dataclass
class Point:
    x: float = 1.5


@dataclass
class Pose:
    position: Point = field(default_factory=Point)


@dataclass
class Joints:
    """As rclpy has it: arrays as array.array or numpy."""

    name: Any = ('elbow', 'left/shoulder.1')
    position: Any = field(default_factory=lambda: array.array('d', [0.25, 0.5]))
    velocity: Any = field(default_factory=lambda: np.array([3, 4], dtype=np.float32))
    poses: Any = field(default_factory=lambda: [Pose(), Pose(Point(7.0))])
    steps: Any = field(default_factory=lambda: array.array('i', [1]))
    on: bool = True
    label: str = 'joint'
    raw: bytes = b'ab'


FIELDS = {
    'pkg/Joints': {
        'name': 'sequence<string>', 'position': 'sequence<double>', 'covariance': 'double[9]',
        'poses': 'sequence<pkg/Pose, 5>', 'label': 'string', 'pose': 'pkg/Pose', 'on': 'boolean',
    },
    'pkg/Pose': {'position': 'pkg/Point'},
    'pkg/Point': {'x': 'double', 'y': 'float', 'z': 'int8', 'raw': 'octet'},
    'pkg/Array': {'data': 'sequence<double>'},
}  # fmt: skip


@pytest.mark.parametrize(
    ('text', 'value'),
    [
        ('position[0]', 0.25),
        ('position[left/shoulder.1]', 0.5),
        ('velocity[elbow]', 3.0),
        ('poses[1].position.x', 7.0),
        ('poses[left/shoulder.1].position.x', 7.0),
        ('on', 1.0),
    ],
)
def test_a_path_leads_to_its_number(text: str, value: float) -> None:
    path = FieldPath.parse(text)
    read = path.read(Joints())
    assert read == value and type(read) is float
    assert str(path) == text


@pytest.mark.parametrize(
    ('text', 'value', 'found'),
    [
        ('position[elbow]', 2.5, 2.5),
        ('position[wrist]', 2.5, 2.5),
        ('position[4]', 2.5, 2.5),
        ('velocity[1]', 2.5, 2.5),
        ('poses[1].position.x', 2.5, 2.5),
        ('steps[2]', 2.6, 3.0),
        ('on', 0.0, 0.0),
    ],
)
def test_a_number_is_found_where_it_was_written(text: str, value: float, found: float) -> None:
    message = Joints(name=['elbow', 'left/shoulder.1'])
    FieldPath.parse(text).write(message, value)
    assert FieldPath.parse(text).read(message) == found


def test_names_written_one_after_the_other_keep_their_own_values() -> None:
    message = Joints(name=[], position=array.array('d'))
    for k, name in enumerate(('left', 'right', 'left')):
        FieldPath.parse(f'position[{name}]').write(message, k)
    assert (message.name, list(message.position)) == (['left', 'right'], [2.0, 1.0])


def test_a_number_that_has_no_place_is_refused() -> None:
    with pytest.raises(MessageError, match='poses has 2 entries'):
        FieldPath.parse('poses[2].position.x').write(Joints(), 1.0)


@pytest.mark.parametrize(
    ('text', 'reason', 'message'),
    [
        ('positon[0]', 'no_field', "Joints has no field 'positon'"),
        ('position[2]', 'no_entry', 'position has 2 entries, but not position[2]'),
        ('position[elbw]', 'no_entry', "no 'elbw' in name: did you mean 'elbow'?"),
        ('poses[0].position[x]', 'no_entry', 'no field name, names, joint_names'),
        ('position', 'not_a_number', 'position is a array, not a number'),
        ('velocity', 'not_a_number', 'velocity is a ndarray, not a number'),
        ('label', 'not_a_number', 'label is a str, not a number'),
        ('label[0]', 'no_entry', 'label is no array'),
        ('raw[0]', 'no_entry', 'raw is no array'),
        ('on[0]', 'no_entry', 'on is no array'),
    ],
)
def test_a_message_without_it_says_why(text: str, reason: str, message: str) -> None:
    with pytest.raises(MessageError, match=re.escape(message)) as caught:
        FieldPath.parse(text).read(Joints())
    assert caught.value.reason == reason


@pytest.mark.parametrize(
    'text',
    [
        '', '.', 'a.', '.a', 'a..b', 'a[', 'a[]', 'a]', 'a[0][1]', 'a[0]b', '[0]', 'a b', 'a()',
        '__class__', '_slots', 'a.__class__.__mro__', '__import__("os")', 'a;b', 'a[[0]]', 'ä',
        'a' * 501,
    ],
)  # fmt: skip
def test_what_is_no_path_is_refused(text: str) -> None:
    with pytest.raises(ValueError):
        FieldPath.parse(text)


@given(st.text(max_size=40))
def test_any_text_is_read_or_refused_and_nothing_runs(text: str) -> None:
    try:
        path = FieldPath.parse(text)
    except ValueError:
        return
    assert FieldPath.parse(str(path)) == path
    assert not any(step.field.startswith('_') for step in path.steps)
    try:
        assert path.read(Point()) == 1.5
    except MessageError:
        return
    assert str(path) == 'x'


fields = st.from_regex(r'[a-zA-Z][a-zA-Z0-9_]{0,8}', fullmatch=True)
labels = st.text(
    st.characters(codec='utf-8', exclude_characters='[]').filter(str.isprintable),
    min_size=1, max_size=12,
)  # fmt: skip
keys = st.none() | st.integers(0, 99) | labels.filter(lambda s: not (s.isascii() and s.isdecimal()))
paths = st.lists(st.builds(Step, fields, keys), min_size=1, max_size=5).map(tuple).map(FieldPath)


@given(paths)
def test_what_is_written_is_read(path: FieldPath) -> None:
    assert FieldPath.parse(str(path)) == path


@given(paths, st.floats(allow_nan=False))
def test_a_message_made_for_a_path_gives_its_number(path: FieldPath, number: float) -> None:
    value: Any = number
    for step in reversed(path.steps):
        owner = type('Message', (), {})()
        if step.key is not None:
            place = step.key if isinstance(step.key, int) else 1
            value = [None] * place + [value]
        setattr(owner, step.field, value)
        if isinstance(step.key, str):
            if step.field in LABELS:
                return
            owner.name = ['another one' + step.key, step.key]
        value = owner
    assert path.read(value) == number


@pytest.mark.parametrize(
    ('text', 'kind', 'message'),
    [
        ('positon[0]', 'pkg/Joints', "pkg/Joints has no field 'positon': did you mean 'position'"),
        ('pose.position.X', 'pkg/Joints', "pkg/Point has no field 'X'"),
        ('position', 'pkg/Joints', 'not a number: say which entry, as in [0] or [name]'),
        ('pose.position', 'pkg/Joints', 'go on with one of its fields x, y, z, raw'),
        ('label', 'pkg/Joints', 'label is a string, not a number'),
        ('pose.position.raw', 'pkg/Joints', 'is a octet, not a number'),
        ('label[0]', 'pkg/Joints', 'label is a string, not an array'),
        ('label.x', 'pkg/Joints', 'label is a string and has no fields'),
        ('covariance[9]', 'pkg/Joints', 'covariance has 9 entries, the first of them [0]'),
        ('data[speed]', 'pkg/Array', 'give its number, as in data[0]'),
    ],
)
def test_a_path_that_the_type_cannot_have_is_refused(text: str, kind: str, message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        FieldPath.parse(text).check(kind, FIELDS.__getitem__)


@pytest.mark.parametrize(
    'text',
    ['position[3]', 'position[any]', 'poses[a].position.x', 'covariance[8]', 'pose.position.z',
     'on'],
)  # fmt: skip
def test_a_path_that_the_type_has_passes(text: str) -> None:
    FieldPath.parse(text).check('pkg/Joints', FIELDS.__getitem__)


@dataclass
class Quaternion:
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 1.0


@dataclass
class Oriented:
    orientation: Any = field(default_factory=Quaternion)


ROTATIONS = {
    'pkg/Oriented': {'orientation': 'geometry_msgs/Quaternion', 'position': 'pkg/Point'},
    'geometry_msgs/Quaternion': dict.fromkeys('xyzw', 'double'),
    'pkg/Point': {'x': 'double'},
}


@pytest.mark.parametrize('angle', ['roll', 'pitch', 'yaw'])
def test_angles_of_a_quaternion_are_steps(angle: str) -> None:
    message = Oriented()
    path = FieldPath.parse(f'orientation.{angle}')
    path.check('pkg/Oriented', ROTATIONS.__getitem__)
    assert path.read(message) == 0.0
    path.write(message, -1.2)
    assert path.read(message) == pytest.approx(-1.2)
    others = {'roll', 'pitch', 'yaw'} - {angle}
    for other in others:
        assert FieldPath.parse(f'orientation.{other}').read(message) == pytest.approx(0.0)


def test_a_quaternion_that_is_no_rotation_is_refused_with_a_reason_of_its_own() -> None:
    message = Oriented(Quaternion(w=0.0))
    with pytest.raises(
        MessageError, match=r'no yaw: the quaternion .* has norm 0, not 1'
    ) as caught:
        FieldPath.parse('orientation.yaw').read(message)
    assert caught.value.reason == 'not_a_rotation'
    assert FieldPath.parse('orientation.w').read(message) == 0.0


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('orientation.yam', "geometry_msgs/Quaternion has no field 'yam': did you mean 'yaw'"),
        ('orientation', 'go on with one of its fields roll, pitch, yaw, x, y, z, w'),
        ('orientation.yaw.x', 'orientation.yaw.x: yaw is a double and has no fields'),
        ('orientation.yaw[0]', 'yaw[0]: yaw is a double, not an array'),
        ('position.yaw', 'roll, pitch, yaw follow a field of type geometry_msgs/Quaternion'),
        ('yaw', "pkg/Oriented has no field 'yaw': roll, pitch, yaw follow a field of type"),
    ],
)
def test_paths_to_angles_are_checked_by_the_types(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        FieldPath.parse(text).check('pkg/Oriented', ROTATIONS.__getitem__)


def test_only_a_quaternion_has_angles_and_no_entry_of_one() -> None:
    for text in ('position.yaw', 'orientation.yaw[0]', 'orientation.yaw.x'):
        with pytest.raises(MessageError) as caught:
            FieldPath.parse(text).read(type('M', (), {'position': Point(), **vars(Oriented())})())
        assert caught.value.reason == 'no_field'
