"""One self-contained HTML page: no script, nothing loaded from elsewhere, the same bytes every time."""

import base64
import re
from collections.abc import Sequence
from functools import cache
from itertools import count

from jinja2 import Environment, PackageLoader, StrictUndefined, Template, select_autoescape
from markupsafe import Markup, escape

from fatigue_planner.output.reports.html.blocks import Block, Section

REPORT_FILE = "report.html"
_CODE = re.compile(r"`([^`]+)`")


def page(title: str, subtitle: str, summary: Sequence[Block], sections: Sequence[Section]) -> str:
    """The page: a title, what one learns, and numbered sections with numbered figures and tables."""
    return _template().render(
        title=title, subtitle=subtitle, summary=summary, sections=sections, figures=count(1), tables=count(1)
    )


@cache
def _template() -> Template:
    loader = PackageLoader("fatigue_planner.output.reports.html", "")
    environment = Environment(loader=loader, autoescape=select_autoescape(["j2"]), undefined=StrictUndefined)
    environment.trim_blocks = environment.lstrip_blocks = True
    environment.filters |= {"prose": _prose, "base64": _base64, "kind": lambda block: type(block).__name__}
    return environment.get_template("page.html.j2")


def _prose(words: str) -> Markup:
    """Text in which `names` stand out; a per cent sign stays with its number where a line breaks."""
    return Markup(_CODE.sub(r"<code>\1</code>", str(escape(words)).replace(" %", "\u00a0%")))


def _base64(text: str) -> str:
    return base64.b64encode(text.encode()).decode()
