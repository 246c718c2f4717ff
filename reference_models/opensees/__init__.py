"""The same frames by OpenSees, in an environment of its own: to compare times, not to verify."""
