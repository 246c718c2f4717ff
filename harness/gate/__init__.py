"""The gate: what moved since the accepted figures, and what must hold without any."""
