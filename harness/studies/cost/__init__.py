"""What a frequency costs: build, solve and the rest told apart, beside counted work."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import scipy

from analytic import InputError
from analytic.kernel import compiled
from harness.bench import Bench, label
from harness.case import Case
from harness.columns import laid_out
from harness.compare import cell
from harness.figures import COLOURS, panels
from harness.presets import PAPER_ELEMENTS
from harness.request import Option, Plan, Request, whole
from harness.result import Result
from harness.signatures import Array, Figure
from harness.studies.cost import measured
from harness.studies.cost.measured import Call, quartiles
from harness.studies.cost.work import counted, growth_table, work_table
from harness.studies.precision import COUNT, SOLVERS, timed_rows
from harness.tables import Number, Row, Table
from harness.timing import Timed, Timings, Way, time_ways
from harness.unbeaten import Mark, draw, unbeaten
from reference_models import Named

YARDSTICK = "scipy.linalg.eigh of the assembled s=3 pair"
FLOOR = "numpy.linalg.eigh of 10,000 6x6 matrices, per matrix"
MATRICES = 10_000
RIVALS = {name: Named("multipliers", None, (("solver", name),)) for name in SOLVERS}
MOST_POSES = 1_000_000
LONG_SHARE = 60.0
"""No core is given more poses than it solves in this time [s]."""


def _batches(text: str) -> tuple[int, ...]:
    sizes = [whole("batches", 1, MOST_POSES)(part.strip()) for part in text.split(",")]
    if len(sizes) > 32:
        raise InputError("batches", text, "at most 32 sizes, such as 1,10,100")
    return tuple(sorted(set(sizes)))


DEFAULTS = {"references": "all", "elements": "1,2,4,8,16,32,64", "cases": "case2"}
OPTIONS = (
    Option("repeats", "N", "How often everything is timed; default 7.", "7",
           whole("repeats", 1, 1000)),
    Option("poses_a_core", "N", "Poses a core where all cores work; default 100000.", "100000",
           whole("poses_a_core", 1, MOST_POSES)),
    Option("batches", "N,N", "Poses a call; default 1,10,100,1000,10000,100000.",
           "1,10,100,1000,10000,100000", _batches),
)  # fmt: skip


@dataclass(frozen=True)
class Cost(Result):
    """A whole run at `case`: `timings` of every model against s, and of batches of poses.

    Attributes: `plain`, our time in times of plain dense solutions; `many`, many poses on many
    cores; `peers`, other programs.
    """

    case: Case
    theory: Named
    timings: Timings
    plain: list[measured.Ratio]
    many: list[measured.Throughput]
    peers: measured.Peers

    @property
    def elements(self) -> list[Timed]:
        """What was timed one pose a call, with its modes."""
        return [t for t in self.timings.timed if not t.way.poses and t is not self.stand_in]

    @property
    def batches(self) -> list[Timed]:
        """What was timed without modes, one pose a call or many."""
        return [t for t in self.timings.timed if t.way.poses]

    @property
    def stand_in(self) -> Timed | None:
        """What stands for the paper's finite elements: the one that is extrapolated."""
        two = (t for t in self.timings.timed if isinstance(t.way.model.elements, tuple))
        return next(two, None)

    @property
    def steps(self) -> list[int]:
        """The numbers of elements that were timed, ascending."""
        return sorted({s for t in self.elements if isinstance(s := t.way.model.elements, int)})

    def ratios(self, one: Timed, yardstick: str) -> Array:
        """Return seconds a pose in times of a yardstick of the same round."""
        return one.each("seconds") / self.timings.yardsticks[yardstick][: len(one.rounds)]

    def ratio(self, one: Timed, yardstick: str) -> float:
        """Return the median of `ratios`."""
        return float(np.median(self.ratios(one, yardstick)))

    def at(self, method: str, size: int | None = PAPER_ELEMENTS) -> Timed | None:
        """Return what one method took with `size` elements, or None."""
        asked = (method, size)
        return next(
            (t for t in self.elements if (t.way.method, t.way.model.elements) == asked), None
        )

    def rivals(self) -> dict[str, Timed]:
        """Return what multipliers took with the paper's number of elements, by solver."""
        asked = {Way(replace(m, elements=PAPER_ELEMENTS)): name for name, m in RIVALS.items()}
        return {asked[t.way]: t for t in self.elements if t.way in asked}

    def records(self) -> Iterator[dict[str, Any]]:
        """Return one row a way and round: seconds a pose, and its parts."""
        for t in self.timings.timed:
            for k, one in enumerate(t.rounds):
                yield {
                    "method": t.way.method, "elements": t.way.size,
                    "poses_a_call": max(1, t.way.poses), "dofs": t.dofs, "round": k + 1,
                    "seconds_a_pose": one.seconds, "build_s": one.build, "solve_s": one.solve,
                }  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return what every model costs, how that grows, and whose seconds they are."""
        found = {
            "-elements": self._elements_table(),
            "-growth": growth_table(self.elements, self.steps, self.case),
            "-work": work_table(self.steps, self.case),
            "-batches": self._batches_table(),
            "-ratios": measured.ratios_table(self.plain),
            "-simulators": measured.simulators_table(self.elements),
            "-cores": measured.cores_table(self.many),
            "-peers": measured.peers_table(self.peers),
        }
        paper = self.case.paper
        return found | ({"-claims": self._claims_table(paper.cost)} if paper and paper.cost else {})

    def _elements_table(self) -> Table:
        parts = ("build", "solve", "rest")
        rows = (
            (t.way.method, t.way.size, t.dofs, *(1e3 * quartiles(t.each("seconds"))),
             *(1e3 * t.median(part) for part in parts), self.ratio(t, YARDSTICK))
            for t in self.elements
        )  # fmt: skip
        columns = dict.fromkeys(("Model", "s", "dofs"))
        columns |= {f"{name} [ms]": 3 for name in ("median", "q1", "q3", *parts)} | {"ratio": 2}
        yard = np.median(self.timings.yardsticks[YARDSTICK])
        notes = (
            f"ratio: to {YARDSTICK}, {1e3 * yard:.3f} ms here",
            "build: the matrices; solve: the eigen-solution; rest: shapes, and what the "
            "interpreter adds; a median each",
            self._circumstances,
            *(f"{method}: {why}" for method, why in self.timings.left_out.items()),
        )
        return laid_out("Cost of one pose against the number of elements", columns, rows, notes)

    def _batches_table(self) -> Table:
        rows = (
            (_alone(t), t.way.size, t.way.poses, *(1e6 * quartiles(t.each("seconds"))),
             self.ratio(t, FLOOR))
            for t in self.batches
        )  # fmt: skip
        columns = dict.fromkeys(("Model", "s", "poses a call"))
        columns |= dict.fromkeys(("median [us]", "q1 [us]", "q3 [us]", "6x6 eigh"), 2)
        floor = 1e6 * np.median(self.timings.yardsticks[FLOOR])
        note = f"all a pose; 6x6 eigh: ratio to {FLOOR}, {floor:.2f} us here"
        title = "Cost of a pose against the number of poses a call"
        return laid_out(title, columns, rows, (note, self._circumstances))

    def _claims_table(self, said: Mapping[str, float]) -> Table:
        """Return what the paper claims next to what this run measured."""
        own, rows = self.at(self.theory.name), list[Row]()
        rivals = {one.way.method: one for one in self.rivals().values()}
        both = {"theoretical model": own, "finite-element model": self.stand_in}
        for claim, one in (both | rivals).items():
            if own is None or one is None:
                continue
            mine, its = (f"{t.way.method}, s={t.way.size}" for t in (own, one))
            rows.append((claim, "s", cell(said.get(claim, np.nan)), Number(one.median(), 4), its))
            if one is not own:
                pairs = zip(own.each("seconds"), one.each("seconds"), strict=False)
                saved = 100 * float(np.median([1 - a / b for a, b in pairs]))
                printed = cell(said.get("cost saved", np.nan) if one is self.stand_in else np.nan)
                rows.append((f"cost saved against {its}", "%", printed, cell(saved), mine))
        columns = ("Claim", "Unit", "Paper", "Here", "What was measured")
        notes = (
            "the paper compares with finite elements (ANSYS) alone and says neither on what "
            "machine nor what the times include; it gives no time with multipliers",
            self._circumstances,
        )
        return Table("What the paper claims, and what was measured", columns, rows, notes)

    @property
    def _circumstances(self) -> str:
        return (
            f"{self.case.name}, {self.timings.rounds} rounds of everything, one BLAS thread; "
            f"numpy {np.__version__}, scipy {scipy.__version__}"
        )

    def figures(self) -> dict[str, Figure]:
        """Return (a) one pose against elements and (b) a pose against poses a call, both log-log.

        Ways that nothing beats are named: in (a) more elements for less time win, in (b) fewer
        poses a call. (a) joins a method's numbers of elements, (b) a model's numbers of poses.
        """
        title, far = "Ways that nothing beats; grey: all others", 2 * max(self.steps)
        heads = (f"modes of one pose, {YARDSTICK} = 1", f"frequencies, {FLOOR} = 1")
        figure, ((left, right),) = panels(title, 1, 2, (5.8, 5.4), heads)
        single, batched = list[Mark](), list[Mark]()
        for t in self.timings.timed:
            model, name = t.way.model, _alone(t)
            if t.way.poses:
                batched.append(Mark(t.way.poses, self.ratio(t, FLOOR), name, label(model)))
            elif model.elements is None:
                ratio = self.ratio(t, YARDSTICK)
                single.append(Mark(far, ratio, f"{name}, exact", label(model)))
            elif isinstance(model.elements, int):
                single.append(Mark(model.elements, self.ratio(t, YARDSTICK), name, name))
        draw(left, single, {COLOURS[0]: unbeaten(single, lambda p: (p.y, -p.x))}, rises=True)
        draw(right, batched, {COLOURS[3]: unbeaten(batched, lambda p: (p.x, p.y))})
        for axes, what in ((left, "one"), (right, "a")):
            axes.set_ylabel(f"time of {what} pose / yardstick")
            axes.title.set_fontsize(9)
            axes.margins(x=0.2, y=0.12)
        left.set_xticks([*self.steps, far], [*map(str, self.steps), "exact"])
        left.set_xticks([], minor=True)
        left.set_xlabel("number of elements $s$")
        right.set_xlabel("poses a call")
        return {"": figure}

    def sentences(self) -> list[str]:
        """Return what a pose costs in large batches, and what multipliers cost beside it."""
        most = (max((t.way.poses for t in self.batches), default=0), "exact")
        large = [t for t in self.batches if (t.way.poses, t.way.size) == most]
        each = "; ".join(
            f"{t.way.method}: {self.ratio(t, FLOOR):.1f} ({1e6 * t.median():.0f} us)" for t in large
        )
        own = self.at(self.theory.name)
        return [
            *([f"A pose costs, in times of one 6x6 numpy.linalg.eigh: {each}."] if each else []),
            *(f"At s = {PAPER_ELEMENTS} the formulation with multipliers ({solver}) takes "
              f"{rival.median() / own.median():.2f} times as long as the paper's, its "
              f"eigen-solution {rival.median('solve') / own.median('solve'):.2f} times, "
              f"its counted operations {self.operations(solver):.2f} times."
              for solver, rival in self.rivals().items() if own is not None),
        ]  # fmt: skip

    def operations(self, formulation: str, s: int = PAPER_ELEMENTS) -> float:
        """Return counted operations of a formulation in times of the paper's."""
        paper, one = (counted(name, s, self.case).flops for name in ("paper", formulation))
        return one / paper

    def rows(self) -> list[dict[str, Any]]:
        """Return a row a way and mode for the history."""
        return [row for t in self.timings.timed for row in timed_rows(t, [self.case], "cost")]

    def failures(self) -> dict[str, str]:
        """Return what has no answer, and why."""
        return self.timings.failures


def measure(
    case: Case,
    theory: Named,
    references: Sequence[Named],
    elements: Sequence[int],
    batches: Sequence[int],
    rounds: int,
    bench: Bench,
    poses_a_core: int,
) -> Cost:
    """Time all models at `case` in `rounds` rounds; the paper's s = 3 is always one of them."""
    steps = sorted({*elements, PAPER_ELEMENTS})
    # Of limbs of any chain there is one solver, and no compiled loop.
    simple, limit = case.mechanism.simple, theory.limit()
    solvers = [("solver", name) for name in ("dense", "sparse")] if simple else []
    variants = (replace(theory, settings=(*theory.settings, solver)) for solver in solvers)
    kinds = [theory, *variants, *RIVALS.values()]
    fast = [(("fast", True),)] if simple and compiled() else []
    loops = [Named("condensed", None, settings) for settings in ((), *fast)]
    ways = [
        *(Way(replace(kind, elements=s)) for kind in kinds for s in steps),
        *(Way(replace(loop, elements=s), 1) for loop in loops for s in (*steps, None)),
        *([] if limit is None else [Way(limit)]),
    ]
    for model in references:
        info = model.info()
        # Of what is slow the first of the meshes that it is extrapolated from.
        meshes = (info.refinements or info.ladder)[:1] if info.slow else steps
        ways += [Way(replace(model, elements=s)) for s in meshes]
    ways += [Way(model) for model in references[:1] if isinstance(model.elements, tuple)]
    ways += [
        Way(replace(loop, elements=s), size)
        for loop in loops for s in (steps[0], steps[-1], None) for size in batches if size > 1
    ]  # fmt: skip
    yardsticks: dict[str, tuple[Call, int]] = {
        YARDSTICK: (partial(scipy.linalg.eigh, *measured.dense_pair(case)), 1),
        FLOOR: (measured.eigh_of(MATRICES), MATRICES),
    }
    timings = time_ways(bench, list(dict.fromkeys(ways)), [case], rounds, COUNT, yardsticks)
    most = {t.way.model: t for t in timings.timed if t.way.poses > 1}
    plain = measured.ratios(case, rounds, min((t.way.poses for t in most.values()), default=0))
    others = measured.frames(case, rounds)
    slowest = max((most[loop].median() for loop in loops if loop in most), default=1.0)
    poses = min(poses_a_core, max(1, int(LONG_SHARE / slowest)))
    plainly = [replace(loop, settings=loop.settings or (("fast", False),)) for loop in loops]
    cores, failed = measured.throughput(case, plainly, poses, bench.limit)
    timings = replace(timings, failures=timings.failures | failed)
    return Cost(case, theory, timings, plain, cores, others)


def run(request: Request, bench: Bench) -> Cost:
    """Return what every model costs at the first case, all timed in one run on one thread."""
    options = request.options
    return measure(
        request.cases[0], request.theory, request.references, request.steps, options["batches"],
        options["repeats"], bench, options["poses_a_core"],
    )  # fmt: skip


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: every model, at the last case."""
    options = {"repeats": 3, "batches": (1, 10, 100, 1000, 10_000), "poses_a_core": 20_000}
    steps = (1, 2, 4, 8, 16, 32, 64)
    return {"cost": plan.request(cases=plan.cases[-1:], references=plan.references, elements=steps,
                                 options=options)}  # fmt: skip


def _alone(t: Timed) -> str:
    """Return a method without its poses a call."""
    return replace(t.way, poses=0).method
