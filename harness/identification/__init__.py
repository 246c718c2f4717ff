"""Which mechanism a table of frequencies belongs to."""
