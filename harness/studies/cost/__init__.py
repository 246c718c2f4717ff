"""What a frequency costs: build, solve and the rest told apart, beside counted work."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import scipy

from analytic import InputError, Substructure
from harness.bench import Bench
from harness.case import Case
from harness.compare import cell, cells
from harness.presets import PAPER_ELEMENTS
from harness.request import Option, Plan, Request, whole
from harness.result import Result
from harness.signatures import Array, Figure
from harness.studies.cost.cores import Throughput, cores_table, throughput
from harness.studies.cost.growth import growth_table
from harness.studies.cost.peers import Peers, measured, peers_table
from harness.studies.cost.ratios import Ratio, ratios, ratios_table
from harness.studies.cost.simulators import simulators_table
from harness.studies.cost.work import counted, work_table
from harness.studies.precision import COUNT, SOLVERS, timed_rows
from harness.tables import Cell, Number, Table
from harness.timing import Timed, Timings, Way, time_ways
from reference_models import Named

YARDSTICK = "scipy.linalg.eigh of the assembled s=3 pair"
FLOOR = "numpy.linalg.eigh of 10,000 6x6 matrices, per matrix"
MATRICES = 10_000
PLAINLY = (("fast", False),)
"""What keeps many poses from the compiled loop."""
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
    plain: tuple[Ratio, ...]
    many: tuple[Throughput, ...]
    peers: Peers

    @property
    def elements(self) -> tuple[Timed, ...]:
        """What was timed one pose a call, with its modes."""
        return tuple(t for t in self.timings.timed if not t.way.poses and t is not self.stand_in)

    @property
    def batches(self) -> tuple[Timed, ...]:
        """What was timed without modes, one pose a call or many."""
        return tuple(t for t in self.timings.timed if t.way.poses)

    @property
    def stand_in(self) -> Timed | None:
        """What stands for the paper's finite elements: the one that is extrapolated."""
        two = (t for t in self.timings.timed if isinstance(t.way.model.elements, tuple))
        return next(two, None)

    def ratios(self, one: Timed, yardstick: str) -> Array:
        """Return seconds a pose in times of a yardstick of the same round."""
        yard = self.timings.yardsticks[yardstick]
        return one.each("seconds") / yard[: len(one.rounds)]

    def at(self, method: str, size: int | None = PAPER_ELEMENTS) -> Timed | None:
        """Return what one method took with `size` elements, or None."""
        found = (
            t for t in self.elements if t.way.method == method and t.way.model.elements == size
        )
        return next(found, None)

    def rivals(self) -> dict[str, Timed]:
        """Return what multipliers took with the paper's number of elements, by solver."""
        ways = {
            solver: Way(Named("multipliers", None, (("solver", solver),))) for solver in SOLVERS
        }
        found = {solver: self.at(way.method) for solver, way in ways.items()}
        return {solver: one for solver, one in found.items() if one is not None}

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
            "-ratios": ratios_table(self.plain),
            "-simulators": simulators_table(self.elements),
            "-cores": cores_table(self.many),
            "-peers": peers_table(self.peers),
        }
        paper = self.case.paper
        return found | ({"-claims": self._claims_table(paper.cost)} if paper and paper.cost else {})

    def _elements_table(self) -> Table:
        parts = ("build", "solve", "rest")
        rows = tuple(
            (t.way.method, t.way.size, "-" if t.dofs is None else t.dofs,
             *cells(1e3 * _quartiles(t), 3), *cells((1e3 * t.median(name) for name in parts), 3),
             Number(float(np.median(self.ratios(t, YARDSTICK))), 2))
            for t in self.elements
        )  # fmt: skip
        columns = ("Model", "s", "dofs", "median [ms]", "q1 [ms]", "q3 [ms]",
                   *(f"{name} [ms]" for name in parts), "ratio")  # fmt: skip
        yard = float(np.median(self.timings.yardsticks[YARDSTICK]))
        notes = (
            f"ratio: to {YARDSTICK}, {1e3 * yard:.3f} ms here",
            "build: the matrices; solve: the eigen-solution; rest: shapes, and what the "
            "interpreter adds; a median each",
            *self._circumstances(),
            *(f"{method}: {why}" for method, why in self.timings.left_out.items()),
        )
        return Table("Cost of one pose against the number of elements", columns, rows, notes)

    @property
    def steps(self) -> list[int]:
        """The numbers of elements that were timed, ascending."""
        return sorted({s for t in self.elements if isinstance(s := t.way.model.elements, int)})

    def _batches_table(self) -> Table:
        rows = tuple(
            (replace(t.way, poses=0).method, t.way.size, t.way.poses,
             *cells(1e6 * _quartiles(t)), Number(float(np.median(self.ratios(t, FLOOR))), 2))
            for t in self.batches
        )  # fmt: skip
        columns = ("Model", "s", "poses a call", "median [us]", "q1 [us]", "q3 [us]", "6x6 eigh")
        floor = float(np.median(self.timings.yardsticks[FLOOR]))
        notes = (f"all a pose; 6x6 eigh: ratio to {FLOOR}, {1e6 * floor:.2f} us here",
                 *self._circumstances())  # fmt: skip
        title = "Cost of a pose against the number of poses a call"
        return Table(title, columns, rows, notes)

    def _claims_table(self, said: Mapping[str, float]) -> Table:
        """Return what the paper claims next to what this run measured."""
        own, rows = self.at(self.theory.name), list[tuple[Cell, ...]]()
        rivals = [(one.way.method, one) for one in self.rivals().values()]
        both = [("theoretical model", own), ("finite-element model", self.stand_in)]
        for claim, one in (*both, *rivals):
            if own is None or one is None:
                continue
            printed = cell(said.get(claim, np.nan))
            rows.append((claim, "s", printed, Number(one.median(), 4), _named(one)))
            if one is not own:
                pairs = zip(own.each("seconds"), one.each("seconds"), strict=False)
                saved = 100 * float(np.median([1 - a / b for a, b in pairs]))
                printed = cell(said.get("cost saved", np.nan) if one is self.stand_in else np.nan)
                about = f"cost saved against {_named(one)}"
                rows.append((about, "%", printed, Number(saved, 2), _named(own)))
        columns = ("Claim", "Unit", "Paper", "Here", "What was measured")
        notes = (
            "the paper compares with finite elements (ANSYS) alone and says neither on what "
            "machine nor what the times include; it gives no time with multipliers",
            *self._circumstances(),
        )
        title = "What the paper claims, and what was measured"
        return Table(title, columns, tuple(rows), notes)

    def _circumstances(self) -> tuple[str, ...]:
        return (
            f"{self.case.name}, {self.timings.rounds} rounds of everything, one BLAS thread; "
            f"numpy {np.__version__}, scipy {scipy.__version__}",
        )

    def figures(self) -> dict[str, Figure]:
        """Return (a) one pose against elements and (b) a pose against batch size."""
        from harness.studies.cost.figure import cost_figure

        return {"": cost_figure(self)}

    def sentences(self) -> list[str]:
        """Return what a pose costs in large batches, and what multipliers cost beside it."""
        lines = []
        size = max((t.way.poses for t in self.batches), default=0)
        exact = [t for t in self.batches if t.way.poses == size and t.way.size == "exact"]
        if exact:
            each = "; ".join(
                f"{t.way.method}: {np.median(self.ratios(t, FLOOR)):.1f} "
                f"({1e6 * t.median():.0f} us)"
                for t in exact
            )
            lines.append(f"A pose costs, in times of one 6x6 numpy.linalg.eigh: {each}.")
        own = self.at(self.theory.name)
        return lines if own is None else lines + [
            f"At s = {PAPER_ELEMENTS} the formulation with multipliers ({solver}) takes "
            f"{rival.median() / own.median():.2f} times as long as the paper's, its eigen-solution "
            f"{rival.median('solve') / own.median('solve'):.2f} times, its counted operations "
            f"{self.operations(solver):.2f} times."
            for solver, rival in self.rivals().items()
        ]  # fmt: skip

    def operations(self, formulation: str, s: int = PAPER_ELEMENTS) -> float:
        """Return counted operations of a formulation in times of the paper's."""
        own = counted("paper", s, self.case)
        return counted(formulation, s, self.case).flops / own.flops

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
    poses_a_core: int = 100_000,
) -> Cost:
    """Time all models at `case` in `rounds` rounds; the paper's s = 3 is always one of them."""
    steps = sorted({*elements, PAPER_ELEMENTS})
    # Of limbs of any chain there is one solver, and no compiled loop.
    alone = not case.mechanism.simple
    solvers = () if alone else ("dense", "sparse")
    kinds = [
        theory, *(replace(theory, settings=(*theory.settings, ("solver", s))) for s in solvers),
        *(Named("multipliers", None, (("solver", solver),)) for solver in SOLVERS),
    ]  # fmt: skip
    ways = [Way(replace(kind, elements=s)) for kind in kinds for s in steps]
    loops = [Named("condensed", None, settings) for settings in _loops()[: 1 if alone else None]]
    ways += [Way(replace(loop, elements=s), 1) for loop in loops for s in (*steps, None)]
    limit = theory.limit()
    ways += [Way(limit)] if limit is not None else []
    ways += [
        Way(replace(model, elements=s))
        for model in references
        for s in (_own_mesh(model) if model.info().slow else steps)
    ]
    whole = [Way(model) for model in references[:1] if isinstance(model.elements, tuple)]
    batch = [
        Way(replace(loop, elements=s), size)
        for loop in loops
        for s in dict.fromkeys((steps[0], steps[-1], None))
        for size in batches
        if size > 1
    ]
    pair = Substructure(PAPER_ELEMENTS).matrices(case.mechanism, case.pose)
    K, M = (matrix.toarray() if hasattr(matrix, "toarray") else matrix for matrix in pair)
    A = np.random.default_rng(0).standard_normal((MATRICES, 6, 6))
    yardsticks = {
        YARDSTICK: partial(scipy.linalg.eigh, K, M),
        FLOOR: partial(np.linalg.eigh, A + A.swapaxes(1, 2)),
    }
    asked = list(dict.fromkeys([*ways, *whole, *batch]))
    timings = time_ways(bench, asked, [case], rounds, COUNT, yardsticks)
    yards = timings.yardsticks
    timings = replace(timings, yardsticks={**yards, FLOOR: yards[FLOOR] / MATRICES})
    most = {t.way.model: t for t in timings.timed if t.way.poses > 1}
    plain = ratios(case, rounds, min((t.way.poses for t in most.values()), default=0))
    others = measured(case, COUNT, rounds)
    plainly = [loop if loop.settings else replace(loop, settings=PLAINLY) for loop in loops]
    slowest = max((most[loop].median() for loop in loops if loop in most), default=1.0)
    poses_a_core = min(poses_a_core, max(1, int(LONG_SHARE / slowest)))
    cores, failed = throughput(case, plainly, poses_a_core, COUNT, bench.limit)
    timings = replace(timings, failures=timings.failures | failed)
    return Cost(case, theory, timings, plain, tuple(cores), others)


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


def _loops() -> list[tuple[tuple[str, bool], ...]]:
    """Return the settings of the condensed model's loops that can run here: plain, compiled."""
    from analytic.kernel import compiled

    return [(), (("fast", True),)] if compiled() else [()]


def _own_mesh(model: Named) -> Sequence[int]:
    """Return the first of the meshes that a model is extrapolated from, as for what is slow."""
    info = model.info()
    return (info.refinements or info.ladder)[:1]


def _quartiles(t: Timed) -> Array:
    """Return the median, and the first and the third quartile of the seconds."""
    return np.percentile(t.each("seconds"), [50, 25, 75])


def _named(t: Timed) -> str:
    return f"{t.way.method}, s={t.way.size}"
