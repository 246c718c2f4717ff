"""The page: sections in order, one template each, and the plotting library, in one file."""

from base64 import b64encode
from gzip import compress

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from analytic import __version__
from harness.report import (
    budget,
    claims,
    fig3,
    history,
    provenance,
    shapes,
    status,
    work_precision,
    workspace,
)
from harness.report.ledger import Ledger
from harness.report.sources import Sources

MAKERS = (status, claims, fig3, budget, work_precision, workspace, shapes, history, provenance)


def page(sources: Sources) -> bytes:
    """Return the dashboard as one HTML file that asks for nothing outside itself."""
    ledger = Ledger(sources)
    sections = [maker.section(sources, ledger) for maker in MAKERS]
    environment = Environment(
        loader=PackageLoader("harness.report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    # Infinities and NaN are no JSON: better no page than one that does not open.
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":"), "allow_nan": False}
    environment.filters["pairs"] = lambda names: [(name, name) for name in names]
    environment.globals["numbered"] = lambda count: [(str(i), f"f{i}") for i in range(1, count + 1)]
    parts = [
        {
            "key": one.key,
            "title": one.title,
            "missing": one.missing,
            "data": one.data,
            "script": not one.missing and f"{one.key}.js" in environment.list_templates(),
            "body": ""
            if one.missing
            else Markup(environment.get_template(f"{one.key}.html").render(**one.context)),
        }
        for one in sections
    ]
    text = environment.get_template("page.html").render(
        sections=parts,
        ledger=ledger.records,
        version=__version__,
        plotly=b64encode(compress(get_plotlyjs().encode(), mtime=0)).decode(),
    )
    return text.encode()
