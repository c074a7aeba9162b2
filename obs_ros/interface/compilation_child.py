"""The process that compiles for a node: parameters come on stdin, kernels go into the cache."""

import json
import os
import sys
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from obs_ros.core.kernel_cache import cache_trouble, missing_made_by
from obs_ros.interface.forecast import Forecast
from obs_ros.interface.sensors import with_sensors
from obs_ros.interface.settings import build_observer
from obs_ros.models import load_model


def main() -> None:
    """Compile for the parameters in the first line of stdin; end at once when stdin ends."""
    values = parameters(sys.stdin.buffer.readline().decode())
    threading.Thread(target=end_with_parent, daemon=True).start()
    with missing_made_by(stop_if_useless):
        compile_all(values)
    os._exit(0)  # nothing is left to tidy up


def compile_all(values: Mapping[str, Any]) -> None:
    """Compile all that the node of these parameters does, in the same order."""
    model = with_sensors(load_model(values['model']), values)
    observer = build_observer(model, values)
    observer.prepare()
    if values.get('prediction.enabled'):
        forecast = Forecast(model, lambda _: None)
        forecast.follow(values, getattr(observer, 'unknowns', None))
        forecast.prepare()
    while observer.prepare_more():
        pass


def parameters(text: str) -> dict[str, Any]:
    """Return the values of parameters from JSON, which makes lists of their tuples."""
    values: dict[str, Any] = json.loads(text)
    return {name: tuple(v) if isinstance(v, list) else v for name, v in values.items()}


def stop_if_useless(_: Path) -> None:
    """End before the next kernel where the last one could not be stored."""
    if trouble := cache_trouble():
        print(trouble, file=sys.stderr, flush=True)
        os._exit(1)


def end_with_parent() -> None:
    """End when nobody holds the other end of stdin any more."""
    while os.read(sys.stdin.fileno(), 1024):
        pass
    os._exit(1)


if __name__ == '__main__':
    main()
