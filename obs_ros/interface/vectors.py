"""An estimate as named vectors, which the node publishes and a replay writes."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from obs_ros.core.estimate import UNKNOWN, Estimate, Jump
from obs_ros.core.model import Model, names

TOPICS = (
    'state', 'parameters', 'state_stddev', 'parameters_stddev', 'parameters_interval', 'residual',
    'jump', 'solver',
)  # fmt: skip


class Vector(NamedTuple):
    """Values by name at a stamp (ns), for the topic ~/`topic`, and up to two further figures each.

    As in the message, of which `values` are the positions: the `velocity` of an interval's lower
    end is the upper one, that of a jump its probability; `effort` is a standard deviation.
    """

    topic: str
    stamp: int
    values: Mapping[str, float]
    velocity: Sequence[float] = ()
    effort: Sequence[float] = ()


def publishable(estimate: Estimate) -> bool:
    """Return whether state and parameters are all finite: others are withheld."""
    values = (*estimate.state.values(), *estimate.parameters.values())
    return all(math.isfinite(value) for value in values)


def vectors(estimate: Estimate, model: Model, solver: Mapping[str, float]) -> Iterator[Vector]:
    """Return the vectors of an estimate, stamped like its newest output, jumps at their own time.

    `solver` are figures that the caller adds to those on ~/solver. Of an estimate that is not
    `publishable` that is the only one.
    """
    stamp = estimate.stamp or 0
    figures = {
        'cost': estimate.cost,
        'residual_rms': estimate.residual_rms,
        'evaluations': float(estimate.evaluations),
        **solver,
        **estimate.figures,
    }
    yield Vector('solver', stamp, figures)
    if not publishable(estimate):
        return
    for topic, variables, values in (
        ('state', model.states, estimate.state),
        ('parameters', model.parameters, estimate.parameters),
    ):
        order = names(variables)
        deviations = {name: estimate.stddev.get(name, math.nan) for name in order}
        yield Vector(topic, stamp, {name: values[name] for name in order})
        yield Vector(f'{topic}_stddev', stamp, deviations)
    yield _interval(estimate, names(model.parameters))
    if estimate.innovation:
        spread = tuple(estimate.innovation_stddev.values())
        yield Vector('residual', stamp, estimate.innovation, effort=spread)
    yield from (_jump(jump) for jump in estimate.jumps if jump.new)


def _interval(estimate: Estimate, parameters: Sequence[str]) -> Vector:
    """Return the 95 % intervals: lower ends as values, upper ones as velocity."""
    ends = {name: estimate.interval.get(name, UNKNOWN) for name in parameters}
    lower = {name: low for name, (low, _) in ends.items()}
    upper = tuple(high for _, high in ends.values())
    return Vector('parameters_interval', estimate.stamp or 0, lower, upper)


def _jump(jump: Jump) -> Vector:
    """Return the sizes of a jump, with its probability as velocity and deviations as effort."""
    probability = (jump.probability,) * len(jump.sizes)
    effort = tuple(jump.stddev.get(name, math.nan) for name in jump.sizes)
    return Vector('jump', jump.stamp or 0, jump.sizes, probability, effort)
