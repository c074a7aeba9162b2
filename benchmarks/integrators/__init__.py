"""Integration without a step that anyone chose: see `__main__.py`."""
