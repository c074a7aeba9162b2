"""A scenario published to an estimator at a high rate, and the node's own count of it."""

import time
from collections.abc import Mapping
from typing import NamedTuple

from benchmarks.live import Live, process_seconds
from benchmarks.play import played
from obs_ros import load_model
from obs_ros.core.model import names
from plant_sim.scenarios import load_scenario


class Case(NamedTuple):
    """An observer, the scenario and samples per s and stream that it gets, and its window in s."""

    observer: str
    scenario: str
    rate: int
    window: float | None = None


CASES = (
    Case('sliding_window', 'three_tank', 1000, 2.0),
    Case('gase', 'observer_form_third_order', 500),
)


class Measured(NamedTuple):
    """Messages sent in each stream within `wall` s, the node's figures, shares of one core."""

    sent: int
    wall: float
    figures: Mapping[str, str]
    shares: Mapping[str, float]


def measured(case: Case, seconds: int, domain: int) -> Measured:
    """Start a node, publish so many seconds of the scenario, and end the node."""
    scenario = load_scenario(case.scenario)
    model, epoch = load_model(scenario.model), time.time_ns()
    streams = names(model.inputs), names(model.outputs)
    instants = played(scenario, case.rate * seconds, period=1.0 / case.rate)
    settings = [f'model:={scenario.model}', f'observer:={case.observer}']
    if case.window is not None:
        settings.append(f'window.duration:={case.window}')
    live = Live(domain, *settings)
    busy, own = process_seconds(live.process.pid), time.process_time()
    start = time.monotonic()
    for k, instant in enumerate(instants):
        while (ahead := start + k / case.rate - time.monotonic()) > 0.0:
            time.sleep(ahead)
        live.feed(instant, epoch, streams)
    wall = time.monotonic() - start
    shares = {
        'estimator': (process_seconds(live.process.pid) - busy) / wall,
        'publisher': (time.process_time() - own) / wall,
    }
    live.spin_until(lambda: live.figures['input.received'] == str(len(instants)), 5.0)
    figures = dict(live.figures)
    live.close()
    return Measured(len(instants), wall, figures, shares)
