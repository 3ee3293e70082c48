"""One self-contained HTML page: no script, nothing loaded from elsewhere, the same bytes every time."""

import base64
import re
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import count

from jinja2 import Environment, PackageLoader, StrictUndefined, Template, select_autoescape
from markupsafe import Markup, escape

from fatigue_planner.output.figures.style import Picture
from fatigue_planner.output.reports.html.blocks import Block, Code, Points, Section, Table, Text

REPORT_FILE = "report.html"
_CODE = re.compile(r"`([^`]+)`")


def page(title: str, subtitle: str, summary: Sequence[Block], sections: Sequence[Section]) -> str:
    """The page: a title, what one learns, and numbered sections with numbered figures and tables."""
    figures, tables = count(1), count(1)
    return _template().render(
        title=title,
        subtitle=subtitle,
        summary=summary,
        sections=sections,
        show=lambda block: _show(block, figures, tables),
    )


@cache
def _template() -> Template:
    loader = PackageLoader("fatigue_planner.output.reports.html", "")
    environment = Environment(loader=loader, autoescape=select_autoescape(["j2"]), undefined=StrictUndefined)
    environment.trim_blocks = environment.lstrip_blocks = True
    return environment.get_template("page.html.j2")


def _show(block: Block, figures: Iterator[int], tables: Iterator[int]) -> Markup:
    match block:
        case Text(words):
            return Markup("<p>{}</p>\n").format(_prose(words))
        case Points(items):
            return Markup("<ul>\n{}</ul>\n").format(Markup("").join(_item(item) for item in items))
        case Code(text):
            return Markup("<pre>{}</pre>\n").format(text)
        case Picture():
            return _figure(block, next(figures))
        case Table():
            return _table(block, next(tables))


def _item(words: str) -> Markup:
    return Markup("<li>{}</li>\n").format(_prose(words))


def _prose(words: str) -> Markup:
    """Text in which `names` stand out; a per cent sign stays with its number where a line breaks."""
    return Markup(_CODE.sub(r"<code>\1</code>", str(escape(words)).replace(" %", "\u00a0%")))


def _figure(picture: Picture, number: int) -> Markup:
    data = base64.b64encode(picture.svg.encode()).decode()
    return Markup(
        '<figure><div class="scroll"><img src="data:image/svg+xml;base64,{}" alt="{}"></div>\n'
        '<figcaption><b>Figure {}.</b> {} <span class="words">In words: {}</span> '
        'Data: <a href="{}">{}</a>.</figcaption></figure>\n'
    ).format(
        data, picture.alternative, number, _prose(picture.caption), _prose(picture.alternative),
        picture.data_file, picture.data_file,
    )  # fmt: skip


def _table(table: Table, number: int) -> Markup:
    kinds = [table.alignment(column) for column in range(len(table.header))]
    head = Markup("").join(
        Markup('<th scope="col" class="{}">{}</th>').format(kind, _prose(name))
        for kind, name in zip(kinds, table.header, strict=True)
    )
    body = Markup("").join(
        Markup("<tr>{}</tr>\n").format(
            Markup("").join(
                Markup('<td class="{}">{}</td>').format(kind, _prose(cell))
                for kind, cell in zip(kinds, row, strict=True)
            )
        )
        for row in table.rows
    )
    data = Markup("")
    if table.data_file:
        data = Markup(' Data: <a href="{}">{}</a>.').format(table.data_file, table.data_file)
    return Markup(
        '<div class="scroll"><table><caption><b>Table {}.</b> {}{}</caption>\n'
        "<thead><tr>{}</tr></thead>\n<tbody>\n{}</tbody></table></div>\n"
    ).format(number, _prose(table.caption), data, head, body)
