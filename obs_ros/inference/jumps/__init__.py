"""Parameters that jump inside a window: which, when, by how much, and how sure that is."""
