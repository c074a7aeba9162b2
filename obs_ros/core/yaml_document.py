"""One document of YAML, by a loader that knows what may be built of it."""

from typing import Any


def document(loader: Any) -> Any:
    """Return what a loader of PyYAML, made with a text, finds; raises what it raises."""
    try:
        return loader.get_single_data()
    finally:
        loader.dispose()
