"""Compare, store, draw and gate: the only layer with effects."""
