"""What the main job is asked for; every study makes its own requests of it."""

from dataclasses import dataclass
from typing import Any

from harness.request import Request
from reference_models import Named


@dataclass(frozen=True)
class Plan(Request):
    """What the main job is asked for; Table I and Fig. 3 are drawn against the first reference.

    Attributes: as of `Request`; `elements` of Fig. 3; `solid`: what stands for three-dimensional
    truth, None where no solid can run; `case_file`: whether the cases are the user's own.
    """

    elements: tuple[int, ...] = tuple(range(1, 9))
    solid: Named | None = None
    case_file: bool = False

    def request(self, **changes: Any) -> Request:
        """Return what a study is asked for, some of it changed; elements are each model's own."""
        own = Request(
            self.cases, self.theory, self.references, None, self.shown, absent=self.absent
        )
        return own.with_(**changes)

    @property
    def against(self) -> tuple[Named, ...]:
        """The first reference, and the solid if there is one: a theory's peer, and the truth."""
        solid = () if self.solid is None else (self.solid,)
        return tuple(dict.fromkeys((*self.references[:1], *solid)))
