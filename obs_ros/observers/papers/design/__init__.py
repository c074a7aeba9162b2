"""Observer gains computed off line; what needs a solver for matrix inequalities."""
