import numpy as np
import pytest
from bags import BagMaker

from obs_ros.replay.bag import Binder
from obs_ros.replay.recording import Source, open_recording
from obs_ros.replay.settings import setup

S = 10**9
MODEL = {'model': 'ball_and_beam:BALL'}


def read(path, given=None, **source):
    recording = open_recording(Source(path, **source), setup({**MODEL, **(given or {})}))
    samples = [
        (s.stamp, None if s.u is None else s.u.tolist(), None if s.y is None else s.y.tolist())
        for s in recording
    ]
    return recording, samples


@pytest.mark.parametrize('storage', ['MCAP', 'SQLITE3'])
def test_samples_come_as_a_node_would_have_got_them(tmp_path, storage):
    with BagMaker(tmp_path / 'bag', storage) as bag:
        bag.vector('/plant/output', 5 * S, 2 * S + 7, y=0.5)
        bag.vector('/plant/input', 6 * S, 1 * S, u=0.1)
        bag.vector('/other', 7 * S, 1 * S, u=0.1)
        bag.vector('/plant/output', 8 * S, 3 * S, y=np.nan)
    expected = [(2 * S + 7, None, [0.5]), (S, [0.1], None)]
    recording, samples = read(tmp_path / 'bag')
    assert samples[:2] == expected
    assert samples[2][0] == 3 * S and np.isnan(samples[2][2][0])
    assert recording.done == 1.0
    # A single file out of the folder will do as well.
    (file,) = (tmp_path / 'bag').glob('*.mcap' if storage == 'MCAP' else '*.db3')
    assert read(file)[1][:2] == expected


@pytest.mark.parametrize(
    ('storage', 'compression'),
    [('MCAP', 'STORAGE'), ('MCAP', 'MESSAGE'), ('MCAP', 'FILE'), ('SQLITE3', 'FILE')],
)
def test_bags_may_be_compressed(tmp_path, storage, compression):
    with BagMaker(tmp_path / 'bag', storage, compression) as bag:
        for k in range(100):
            bag.vector('/plant/input', k * S, k * S, u=0.1)
            bag.vector('/plant/output', k * S + 1, k * S, y=float(k))
    _, samples = read(tmp_path / 'bag')
    assert [y for _, _, y in samples[1::2]] == [[float(k)] for k in range(100)]


def test_names_count_and_not_their_order(tmp_path):
    with BagMaker(tmp_path / 'bag') as bag:
        bag.vector('/plant/output', S, S, h2=2.0, h1=1.0)
        bag.vector('/plant/input', 2 * S, S, Q2=20.0, Q1=10.0)
    first, second = open_recording(Source(tmp_path / 'bag'), setup({'model': 'three_tank'}))
    assert first.y.tolist() == [1.0, 2.0]
    assert second.u.tolist() == [10.0, 20.0]


def test_what_does_not_fit_is_counted(tmp_path):
    with BagMaker(tmp_path / 'bag') as bag:
        bag.vector('/plant/output', S, S, z=0.5)
        bag.vector('/plant/output', S, S)
        bag.vector('/plant/input', S, S, u=0.1)
    recording, samples = read(tmp_path / 'bag')
    assert samples == [(S, [0.1], None)]
    assert recording.refused == {'output.missing_name': 2}


def test_further_names_are_ignored_and_counted(tmp_path):
    with BagMaker(tmp_path / 'bag') as bag:
        bag.vector('/plant/output', S, S, other=3.0, y=0.5)
        bag.vector('/plant/input', S, S, u=0.1)
    recording, samples = read(tmp_path / 'bag')
    assert samples == [(S, None, [0.5]), (S, [0.1], None)]
    assert recording.refused == {'output.other_names': 1}


def test_topics_may_have_other_names(tmp_path):
    with BagMaker(tmp_path / 'bag') as bag:
        bag.vector('/line/plant/output', S, S, y=1.0)
        bag.vector('/commands', S, S, u=2.0)
    with pytest.raises(ValueError, match=r'no topic /plant/input: .* --topic input=TOPIC'):
        read(tmp_path / 'bag')
    _, samples = read(tmp_path / 'bag', topics={'input': '/commands'}, node='/line/estimator')
    assert samples == [(S, None, [1.0]), (S, [2.0], None)]
    with pytest.raises(ValueError, match=r'--topic outptu=: did you mean'):
        read(tmp_path / 'bag', topics={'outptu': '/x'})


def test_fields_of_any_message_are_bound_as_in_the_node(tmp_path):
    with BagMaker(tmp_path / 'bag') as bag:
        for k in range(3):
            bag.write('/angle', k * S, 'std_msgs/msg/Float64', data=10.0 * k)
            bag.write(
                '/ball', k * S + 5, 'geometry_msgs/msg/PointStamped', header=bag.header(k * S + 3),
                point=bag.store.types['geometry_msgs/msg/Point'](x=1.0 + k, y=0.0, z=0.0),
            )  # fmt: skip
    given = {
        'signals.u.topic': '/angle', 'signals.u.type': 'std_msgs/msg/Float64',
        'signals.u.field': 'data', 'signals.u.scale': 0.5, 'signals.u.stamp': 'arrival',
        'signals.y.topic': '/ball', 'signals.y.type': 'geometry_msgs/msg/PointStamped',
        'signals.y.field': 'point.x', 'signals.y.offset': -1.0,
    }  # fmt: skip
    expected = [
        entry for k in range(3)
        for entry in ((k * S, [5.0 * k], None), (k * S + 3, None, [float(k)]))
    ]  # fmt: skip
    assert read(tmp_path / 'bag', given)[1] == expected
    with pytest.raises(ValueError, match=r'/angle: std_msgs/msg/Float64 has no header'):
        read(tmp_path / 'bag', {**given, 'signals.u.stamp': 'header'})
    with pytest.raises(ValueError, match=r'/angle has std_msgs/msg/Float64, not std_msgs/msg/Int8'):
        read(tmp_path / 'bag', {**given, 'signals.u.type': 'std_msgs/msg/Int8'})


def test_two_topics_of_one_stream_wait_for_each_other(tmp_path):
    """Recorded time, not that of the replay, says how long."""
    with BagMaker(tmp_path / 'bag') as bag:
        for k in range(4):
            bag.write('/one', 10 * k * S, 'std_msgs/msg/Float64', data=float(k))
            bag.write('/two', 10 * k * S + 1, 'std_msgs/msg/Float64', data=10.0 + k)
            bag.vector('/plant/input', 10 * k * S + 2, 10 * k * S, Q1=1.0, Q2=2.0)
    given = {'model': 'three_tank', 'merge_wait': 5.0}
    for name, topic in (('h1', '/one'), ('h2', '/two')):
        given |= {
            f'signals.{name}.topic': topic, f'signals.{name}.type': 'std_msgs/msg/Float64',
            f'signals.{name}.field': 'data', f'signals.{name}.stamp': 'arrival',
        }  # fmt: skip
    chosen = setup(given)
    outputs = [s for s in open_recording(Source(tmp_path / 'bag'), chosen) if s.y is not None]
    assert [s.stamp for s in outputs] == sorted(10 * k * S + i for k in range(4) for i in (0, 1))


def test_a_topic_that_falls_silent_holds_the_other_for_its_wait_of_recorded_time(tmp_path):
    """Stamps run twenty times as fast as recorded time here: they do not say how long, either."""
    with BagMaker(tmp_path / 'bag') as bag:
        for k in range(8):
            recorded, stamp = 100 * S + k * S // 2, 10 * k * S
            bag.vector('/one', recorded, stamp, a=float(k))
            if k == 0:
                bag.vector('/two', recorded + 1, stamp, a=10.0)
            bag.vector('/plant/input', recorded + 2, stamp, Q1=1.0, Q2=2.0)
    given = {'model': 'three_tank', 'merge_wait': 1.2}
    for name, topic in (('h1', '/one'), ('h2', '/two')):
        given |= {
            f'signals.{name}.topic': topic, f'signals.{name}.field': 'position[a]',
            f'signals.{name}.type': 'sensor_msgs/msg/JointState',
        }  # fmt: skip
    held = {}
    recording = open_recording(Source(tmp_path / 'bag'), setup(given))
    for sample in recording:
        if sample.y is not None:
            k = sample.stamp // (10 * S)
            newest = max(0, round(17 * recording.done) - 2) // 2  # of 17 messages, 3 are k = 0
            held[k] = newest - k
            assert np.isnan(sample.y[1]) == (sample.stamp > 0)
    # 1.2 s are over with the third message after it; the end of the recording frees the last.
    assert list(held.items()) == [(0, 0), (1, 3), (2, 3), (3, 3), (4, 3), (5, 2), (6, 1), (7, 0)]


@pytest.mark.parametrize('storage', ['MCAP', 'SQLITE3'])
def test_a_broken_bag_is_refused_with_its_place(tmp_path, storage):
    with BagMaker(tmp_path / 'bag', storage) as bag:
        for k in range(200):
            bag.vector('/plant/output', k * S, k * S, y=0.5)
            bag.vector('/plant/input', k * S, k * S, u=0.5)
    (file,) = (tmp_path / 'bag').glob('bag.*')
    whole = file.read_bytes()
    for kept in (0, 5, 100, len(whole) // 2, len(whole) - 20):
        file.write_bytes(whole[:kept])
        with pytest.raises(ValueError, match=r'bag'):
            read(file)


def test_a_broken_message_is_named(tmp_path):
    kind = 'sensor_msgs/msg/JointState'
    with BagMaker(tmp_path / 'bag') as bag:
        bag.vector('/plant/output', S, S, y=0.5)
        bag.vector('/plant/input', S, S, u=0.5)
        bag.raw('/plant/output', 2 * S, kind, b'\x00\x01\x00\x00' + b'\xff' * 30)
    with pytest.raises(ValueError, match=r'message 3, on /plant/output: cannot be decoded'):
        read(tmp_path / 'bag')
    with BagMaker(tmp_path / 'large') as bag:
        bag.vector('/plant/input', S, S, u=0.5)
        bag.raw('/plant/output', 2 * S, kind, bytes(Binder.largest + 1))
    with pytest.raises(ValueError, match=f'message 2, .* more than {Binder.largest}'):
        read(tmp_path / 'large')


def test_options_that_do_not_suit_are_refused(tmp_path):
    (tmp_path / 'bag').mkdir()
    (tmp_path / 'a.csv').write_text('t,u,y\n')
    (tmp_path / 'a.png').write_text('')
    for name, options, message in (
        ('bag', {'period': 0.1}, 'is a bag: columns and a period are for tables'),
        ('bag', {}, 'cannot be read as a bag'),
        ('a.csv', {'topics': {'input': '/x'}}, 'is a table: topics are for bags'),
        ('a.png', {}, 'is no recording known here'),
    ):
        with pytest.raises(ValueError, match=message):
            open_recording(Source(tmp_path / name, **options), setup(MODEL))
    with pytest.raises(FileNotFoundError, match=r"b.csv does not exist: did you mean 'a.csv'"):
        open_recording(Source(tmp_path / 'b.csv'), setup(MODEL))
