"""Windows one after the other: what was learned is carried on, and what jumped is found."""
