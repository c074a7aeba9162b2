"""Made-up samples, such as take all ways through an observer that goes sample by sample."""

from collections.abc import Iterator

import numpy as np

from obs_ros.core.model import Model, inside
from obs_ros.core.record import Sample
from obs_ros.core.saturation import at_an_end
from obs_ros.core.typing import Array
from obs_ros.integration.time_scales import modes, shortest_time
from obs_ros.observers.output_intake import outputs_at


def rehearsed(model: Model, x: Array, p: Array, count: int, gap: float) -> Iterator[Sample]:
    """Yield so many samples for an observer that starts from states x (n,) and parameters p (q,).

    They follow each other by the period of a discrete model, or within `gap` s, 1 s, a step of the
    model and the time of its fastest mode. The outputs of the last one are at the ends of all
    ranges, which takes a rollout.
    """
    u = np.array([inside(variable) for variable in model.inputs])
    step = model.period or min(model.max_step, gap, 1.0, shortest_time(modes(model, 0.0, x, u, p)))
    period = max(1, round(1e9 * step))
    with np.errstate(all='ignore'):
        y = outputs_at(model, 0.0, u, x, p)
    y = np.where(np.isfinite(y), y, 0.0)
    for k in range(count):
        last = k == count - 1
        yield Sample(k * period, y=at_an_end(model.outputs, y) if last else y, u=u)
