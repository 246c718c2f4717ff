"""The command line: the only place that knows click, flags and the terminal."""
