"""The commands that solve a study at named cases: options to objects, results to files."""

from dataclasses import replace
from pathlib import Path

import click

from harness.options import STAND_IN, Request, takes_request
from harness.tables import table_files
from harness.terminal import finish, progress, show, write


@click.command()
@takes_request
def table(request: Request) -> int:
    """Table I: FEA, Theoretical and Error (%), beside what the paper prints.

    Without --model the theory is the one that the first case is meant for.
    """
    from harness.compare import provenance_table, reference_table, table_one
    from harness.reproduce import tidy
    from harness.run import rows, run

    cases, shown, against = request.chosen, request.shown, request.against(STAND_IN)
    theory, folder = request.theory(cases[0].model), request.folder
    theories = [theory]
    if request.elements is not None:
        theories = [replace(theory, elements=s) for s in request.steps("")]
    with progress(len(cases) * (len(theories) + len(against))) as done:
        study = run(cases, [*theories, *against], max(shown), done)
    tables = {"table1": table_one(study, theories, against, shown)}
    for spec in theories:
        tables[f"references-{spec.label}"] = reference_table(study, spec, against, shown)
    tables["provenance"] = provenance_table(study)
    show(*tables.values())
    write(folder, {"frequencies.csv": tidy(rows(study))} | table_files(tables))
    return finish(request.history, study)


@click.command()
@takes_request
def convergence(request: Request) -> int:
    """Error against the number of elements s, for every case and mode, as in Fig. 3.

    With --references NAME@exact (euler-bernoulli@exact, say) it is the discretisation error alone,
    with its observed order.
    """
    from harness.convergence import converge, convergence_files, convergence_tables

    cases, shown, against = request.chosen, request.shown, request.against(STAND_IN)
    theory, steps, folder = request.theory(cases[0].model), request.steps("1-8"), request.folder
    with progress(len(against) * len(cases) * (1 + len(steps))) as done:
        results = [converge(cases, theory, steps, ref, max(shown), done) for ref in against]
    files: dict[str, bytes] = {}
    for result in results:
        show(*convergence_tables(result, shown))
        if folder is not None:
            stem = f"convergence-{result.reference.label}"
            files |= convergence_files(result, shown, stem)
    write(folder, files)
    return finish(request.history, *(result.study for result in results))


@click.command()
@takes_request
def refine(request: Request) -> int:
    """Observed order, Richardson limit and GCI of the theory and of every reference.

    Without --elements each reference doubles from half its own coarser mesh, the theory from 4.
    """
    from harness import refinement

    cases, shown, against = request.chosen, request.shown, request.against(STAND_IN)
    theory, folder = request.theory(cases[0].model), request.folder
    ladders = [refinement.ladder(spec, request.steps_or_none) for spec in (theory, *against)]
    with progress(len(cases) * sum(map(len, ladders))) as done:
        result = refinement.refine(cases, ladders, max(shown), done)
    tables = refinement.refinement_tables(result, shown)
    show(*tables)
    files: dict[str, bytes] = {}
    for steps, table in zip(ladders, tables, strict=True):
        files |= table.files(f"refinement-{steps[0].name}")
    write(folder, files)
    return finish(request.history, result.study)


@click.command()
@takes_request
def budget(request: Request) -> int:
    """The error split into its causes: elements, rotary inertia, shear, and what remains.

    Against the first of --references; the parts add up to the error.
    """
    from harness import budget as parts
    from harness.figures import figure_files

    cases, shown, reference = request.chosen, request.shown, request.against(STAND_IN)[0]
    theory, steps, folder = request.theory(cases[0].model), request.steps("1-4"), request.folder
    with progress(len(cases) * len(parts.models(theory, steps, reference))) as done:
        result = parts.budget(cases, theory, steps, reference, max(shown), done)
    table = parts.budget_table(result, shown)
    show(table)
    files = table.files("budget")
    if folder is not None and result.shares:
        files |= figure_files(parts.budget_figure(result, shown), "budget")
        files |= figure_files(parts.floor_figure(result, shown), "floor")
    write(folder, files)
    return finish(request.history, result.study)


@click.command()
@takes_request
def slenderness(request: Request) -> int:
    """Beam theory against 3-D solids at d/L = 0.05, 0.1, 0.15 and 0.2.

    Against the first of --references, by default calculix-solid.
    """
    from harness import slenderness as study
    from harness.figures import figure_files

    cases, shown, folder = request.chosen, request.shown, request.folder
    reference = request.against("calculix-solid")[0]
    with progress(3 * len(cases) * len(study.RATIOS)) as done:
        result = study.slenderness(cases, study.RATIOS, reference, max(shown), done)
    table = study.slenderness_table(result, shown)
    show(table)
    files = table.files("slenderness")
    if folder is not None:
        files |= figure_files(study.slenderness_figure(result, shown), "slenderness")
    write(folder, files)
    return finish(request.history, *result.studies)


@click.command()
@takes_request
def shapes(request: Request) -> int:
    """Mode shapes as in Fig. 4 and 5, beside those of --references, with the assurance matrix.

    Pictures go to --output, by default the folder shapes/.
    """
    from harness.figures import figure_files
    from harness.run import run
    from harness.shapes import assurance_figure, shapes_figure

    cases, shown, against = request.chosen, request.shown, request.against(STAND_IN)
    theory, folder = request.theory(cases[0].model), request.folder or Path("shapes")
    with progress(len(cases) * (1 + len(against))) as done:
        study = run(cases, [theory, *against], max(shown), done)
    files: dict[str, bytes] = {}
    for case in cases:
        figure = shapes_figure(study, case, [theory, *against], shown)
        files |= figure_files(figure, f"shapes-{case.name}", forms=("png",))
        for reference in against:
            matrix = assurance_figure(study, case, theory, reference, shown)
            if matrix is not None:
                files |= figure_files(matrix, f"assurance-{case.name}-{reference.label}")
    write(folder, files)
    return finish(request.history, study)
