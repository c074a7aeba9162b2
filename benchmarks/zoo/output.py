"""The output that most plants of the zoo have."""

from typing import Any


def first_state(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    """Return the first state."""
    return (x[0],)
