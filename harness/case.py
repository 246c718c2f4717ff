"""A case: a mechanism at a pose, and what of it was read, or fitted."""

from dataclasses import dataclass, field

from analytic import InputError, Mechanism, Pose
from analytic.plausible import warn_of
from analytic.pose import one_pose
from harness.paper import Paper, Printed
from reference_models import Named


@dataclass(frozen=True)
class Case:
    """A mechanism at a pose.

    Attributes: `name`; `mechanism`; `pose`; `note`, where its numbers come from; `theory`, the
    model it is meant for; `paper`, which prints frequencies of the case `published` in its table;
    `errata`, the ids of that paper's errata that explain its numbers; `title`, what a figure calls
    it. Raises `InputError` for anything but a mechanism and one pose; warns of what is hardly
    meant, such as GPa for Pa.
    """

    name: str
    mechanism: Mechanism
    pose: Pose
    note: str
    theory: Named = Named("euler-bernoulli", 3)  # noqa: RUF009  frozen
    published: str = ""
    errata: tuple[str, ...] = ()
    title: str = ""
    paper: Paper | None = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        one_pose(self.mechanism, self.pose)
        if not isinstance(self.name, str) or not self.name:
            raise InputError("Case.name", self.name, "a name")
        warn_of(self.mechanism, self.pose)

    @property
    def heading(self) -> str:
        """The case in words, for a figure."""
        return self.title or self.name

    @property
    def printed(self) -> tuple[Printed, ...]:
        """What its paper prints of it."""
        return () if self.paper is None else self.paper.table.get(self.published, ())

    @property
    def prints_errors(self) -> bool:
        """Whether its paper prints the error of one row against another, as Table I does."""
        return any(one.error is not None for one in self.printed)
