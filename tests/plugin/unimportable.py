"""A plug-in whose simulator is not installed."""

import no_such_simulator  # noqa: F401  # type: ignore[import-not-found]
