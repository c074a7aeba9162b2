"""Estimates written down as they come: as a table, and as a bag."""

import csv
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from obs_ros.core.estimate import UNKNOWN, Estimate
from obs_ros.core.model import Model, names
from obs_ros.interface.vectors import TOPICS, Vector, vectors
from obs_ros.replay.extras import require

Take = Callable[[Estimate, int], None]

TYPE = 'sensor_msgs/msg/JointState'
NODE = '/estimator'


@contextmanager
def table_writer(path: Path, model: Model) -> Iterator[Take]:
    """Return a function that writes a row for each estimate: time, outcome, values, residuals.

    Behind the values stand standard deviations and the ends of 95 % intervals.
    Numbers are written so that they are read back bit by bit.
    """
    with path.open('w', newline='', encoding='utf-8') as file:
        rows = csv.writer(file, lineterminator='\n')
        rows.writerow(columns(model))

        def take(estimate: Estimate, skipped: int) -> None:
            rows.writerow(map(written, row(estimate, model, skipped)))

        yield take


def columns(model: Model) -> dict[str, type]:
    """Return the columns of a table of estimates, each with the type of its cells."""
    unknowns = names(model.variables)
    return {
        't': float, 'stamp_ns': int, 't0': float, 'outcome': str,
        **dict.fromkeys(unknowns, float),
        **{f'{name}_{part}': float for part in ('stddev', 'lower', 'upper') for name in unknowns},
        **{f'residual_rms.{name}': float for name in names(model.outputs)},
        'residual_rms': float, 'cost': float, 'skipped': int, 'jumps': str, 'message': str,
    }  # fmt: skip


def row(estimate: Estimate, model: Model, skipped: int) -> list[float | int | str]:
    """Return the cells of an estimate, one for each of the `columns`."""
    unknowns = names(model.variables)
    values = {**estimate.state, **estimate.parameters}
    ends = [estimate.interval.get(name, UNKNOWN) for name in unknowns]
    numbers = (
        *(values[name] for name in unknowns),
        *(estimate.stddev.get(name, np.nan) for name in unknowns),
        *(low for low, _ in ends),
        *(high for _, high in ends),
        *(estimate.output_rms.get(name, np.nan) for name in names(model.outputs)),
        estimate.residual_rms,
        estimate.cost,
    )
    return [
        float(estimate.t1), estimate.stamp or 0, float(estimate.t0), estimate.outcome.value,
        *map(float, numbers), skipped, '; '.join(str(jump) for jump in estimate.jumps if jump.new),
        estimate.message,
    ]  # fmt: skip


def written(cell: float | int | str) -> str:
    """Return a cell as text, a number so that it is read back bit by bit."""
    return cell if isinstance(cell, str) else repr(cell)


@contextmanager
def bag_writer(path: Path, model: Model) -> Iterator[Take]:
    """Return a function that writes each estimate to a bag (MCAP), on the topics of the node.

    All is recorded at the time of the newest output used, jumps too, whose own time is in their
    stamp. Times that a clock has measured are left out: the same estimates give the same bytes.

    Raises MissingPackageError.
    """
    rosbag2 = require('rosbags.rosbag2', 'writing a bag')
    typesys = require('rosbags.typesys', 'writing a bag')
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    time_type, header_type, joint_state = (
        store.types[name] for name in ('builtin_interfaces/msg/Time', 'std_msgs/msg/Header', TYPE)
    )
    with rosbag2.Writer(path, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP) as bag:
        connections = {
            topic: bag.add_connection(f'{NODE}/{topic}', TYPE, typestore=store) for topic in TOPICS
        }

        def write(recorded: int, vector: Vector) -> None:
            topic, stamp, values, velocity, effort = vector
            time = time_type(sec=stamp // 10**9, nanosec=stamp % 10**9)
            message = joint_state(
                header=header_type(stamp=time, frame_id=''),
                name=list(values),
                position=np.array([float(value) for value in values.values()]),
                velocity=np.array(velocity, dtype=np.float64),
                effort=np.array(effort, dtype=np.float64),
            )
            bag.write(connections[topic], recorded, store.serialize_cdr(message, TYPE))

        def take(estimate: Estimate, skipped: int) -> None:
            recorded = estimate.stamp or 0
            for vector in vectors(estimate, model, {'skipped': float(skipped)}):
                write(recorded, vector)

        yield take
