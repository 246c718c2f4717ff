"""What hears how far a run is."""


class Listener:
    """It hears of every step, and says nothing of it."""

    def expect(self, number: int) -> None:
        """Take in that so many more steps are to come."""

    def begin(self, what: str) -> None:
        """Take in that a step, in words, begins."""

    def done(self, what: str, steps: int = 1) -> None:
        """Take in that a step, in words, is finished, or several."""
