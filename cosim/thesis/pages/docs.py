"""``docs/experiments.md``: what the runs and sweeps said, as Markdown, and nothing by hand."""

from __future__ import annotations

from importlib.resources import files

from cosim.thesis.claims.chapter_8 import STATEMENTS
from cosim.thesis.claims.past import EXTENSIONS
from cosim.thesis.pages.findings import FINDINGS
from cosim.thesis.pages.phrases import origins
from cosim.thesis.pages.rows import rows
from cosim.thesis.results import Results
from cosim.thesis.sweeps.beyond import RADIUS_DELAYS


def experiments_page(results: Results) -> str:
    """The whole page."""
    from jinja2 import Environment

    template = files("cosim.thesis.pages").joinpath("experiments.md.j2").read_text(encoding="utf-8")
    environment = Environment(autoescape=False, trim_blocks=True, lstrip_blocks=True)
    page = environment.from_string(template).render(
        chapter=results.decided(STATEMENTS),
        past=results.decided(EXTENSIONS),
        rows=rows,
        origins=origins,
        said={name: text(results.sweeps) for name, (_, text, _) in FINDINGS.items()},
        sweeps=results.sweeps,
        delays=RADIUS_DELAYS,
    )
    return page.rstrip() + "\n"
