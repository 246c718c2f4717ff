"""What moved since the accepted figures: the ratchet, properties without a baseline, timings."""
