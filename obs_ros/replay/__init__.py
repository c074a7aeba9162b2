"""Recordings replayed: the node's observer over a bag or a table, faster than real time."""
