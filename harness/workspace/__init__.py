"""Fig. 6: maps of frequencies over the regular workspace."""
