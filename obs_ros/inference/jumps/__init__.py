"""Parameters that jump inside a window: which, when and by how much.

`piecewise` is the model of such a window, `hypothesis` its evidence; `screening` and `moves` lead
from a hypothesis to others, and `jump_search` decides among them.
"""
