"""A record as a discrete model sees it: one row a node."""

from collections.abc import Mapping

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.record import Record
from obs_ros.core.typing import Array
from obs_ros.samples.align import align
from obs_ros.samples.merge import Role
from obs_ros.samples.nodes import NODES, NodeLine
from obs_ros.samples.stream import InputStream, Stream

MOST_NODES = 1e6  # of a record: rollouts take some 100 MB for each variable


class _Streams:
    """The memory of a record: every sample, until it is aligned."""

    passed = None

    def __init__(self, inputs: int, outputs: int, samples: int) -> None:
        self.inputs, self.outputs = InputStream(inputs, samples), Stream(outputs, samples)

    def keep(self, role: Role, stamp: int, values: Array) -> bool:
        """See `Store`."""
        return (self.inputs if role == 'input' else self.outputs).add(stamp, values)

    def forget(self) -> None:
        """See `Store`; a record has one timeline."""


def at_nodes(model: Model, record: Record) -> tuple[Record, str]:
    """Return a record whose samples are those of a discrete model's nodes, each node one row.

    The text names what does not lie on them; it is empty where all does. Of continuous models, or
    with other columns than the model's, it is the very record.

    Raises ValueError where fewer than two outputs are left, or where there are too many nodes.
    """
    widths = record.u.shape[1], record.y.shape[1]
    if model.period is None or widths != (len(model.inputs), len(model.outputs)):
        return record, ''
    nodes = float(record.t[-1] - record.t[0]) / model.period
    if nodes > MOST_NODES:
        raise ValueError(f'split the record: it has {nodes:.3g} nodes, at most {MOST_NODES:g}')
    stamps = np.round(record.t * 1e9).astype(np.int64).tolist()
    counts = {'off_grid': 0, 'duplicate': 0, 'late': 0}
    store = _Streams(*widths, len(stamps))
    line = NodeLine(store, model.period, counts)
    measured = [not np.isnan(row).all() for row in record.y]
    outputs = [stamp for stamp, known in zip(stamps, measured, strict=True) if known]
    line.phase.learn(outputs[: NODES.remembered])
    for k, stamp in enumerate(stamps):
        if not np.isnan(record.u[k]).all():
            line.keep('input', stamp, record.u[k])
        if measured[k]:
            line.keep('output', stamp, record.y[k])
    line.release()
    found = None
    if len(store.outputs):
        since = store.inputs.known_since
        assert since is not None  # a record begins with every input
        store.outputs.drop_until(since - 1)
        end = int(store.outputs.stamps[-1])
        found = align(store.outputs, store.inputs, end, ['hold'] * widths[0], 0, model.period)
    said = off_nodes(counts, model.period)
    if found is None:
        raise ValueError(f'look at period and stamps: fewer than two outputs are on nodes; {said}')
    stamp = None
    if record.stamp is not None:
        stamp = record.stamp + end - outputs[-1]
    return Record(found.t, found.u, found.y, stamp), said


def off_nodes(counts: Mapping[str, int], period: float) -> str:
    """Say how many samples are not on the nodes, and how many share one; '' if all are right."""
    words = []
    if counts['off_grid']:
        words.append(f'{counts["off_grid"]} samples lie between the nodes, {period:g} s apart: '
                     'outputs there do not count, inputs act from the next node on')  # fmt: skip
    if counts['duplicate']:
        words.append(f'{counts["duplicate"]} outputs do not count, as their node has others')
    return '; '.join(words)
