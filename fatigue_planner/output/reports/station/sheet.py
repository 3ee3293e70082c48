"""How high the first side of a station's page is when it is printed, estimated from the letters of its texts.

All lengths are in px (1/96 inch), those of look.css in print on A4, as Chromium measures them; letters are taken as
wide, so that a side that is said to fit does. A test lays the fullest sides out in a browser.
"""

from collections.abc import Iterable, Sequence
from math import ceil

from fatigue_planner.output.reports.page import Points, Table
from fatigue_planner.output.reports.station.blocks import Groups, Part, PostureRow

SHEET_PX = 1031  # A4 without its margins of 12 mm
_WIDTH_PX, _GAP_PX = 688, 23
_TITLE_PX, _HEADING_PX = 75, 35  # title, facts and verdict; the heading of a section and what is around it
# Sentences in two columns.
_GROUP_PX, _SENTENCE_PX, _SENTENCE_LETTERS = 22, 12, 72
# Tables: letters of the columns of `front.places`.
_CAPTION_PX, _CAPTION_LETTERS, _ROW_PX, _CELL_PX, _CELL_LETTERS = 15, 120, 16, 12, (9, 12, 18, 20, 48, 18)
# Pictures beside each other, and their captions.
_FIGURE_PX, _FIGURE_WIDTH_PX, _FIGURE_GAP_PX, _FIGURE_LINE_PX, _FIGURE_LETTERS = 132, 94, 15, 13, 16
# What it rests on: beside the pictures if there is room for it, else below them in two columns.
_REST_PX, _REST_LETTER_PX, _REST_LEAST_PX, _INDENT_PX = 11, 4.4, 302, 15


def printed_px(verdict: str, parts: Sequence[Part]) -> float:
    """How high the side is: its title, its verdict, and sentences, a table, pictures and points, each a part."""
    sentences, table, pictures, rest = (each.blocks[0] for each in parts)
    assert isinstance(sentences, Groups) and isinstance(table, Table) and isinstance(rest, Points)
    above = _TITLE_PX + _SENTENCE_PX * 1.5 * (_lines([verdict], 90) - 1)
    return above + _sentences_px(sentences) + _table_px(table) + _end_px(pictures, rest)


def _lines(texts: Iterable[str], letters: float) -> int:
    return sum(max(1, ceil(len(text) / letters)) for text in texts)


def _sentences_px(block: Groups) -> float:
    """Two columns of equal height; a sentence is not divided."""
    heights = (_GROUP_PX + _SENTENCE_PX * _lines(group.items, _SENTENCE_LETTERS) for group in block.groups)
    return _HEADING_PX + sum(heights) / 2 + 2 * _SENTENCE_PX


def _table_px(table: Table) -> float:
    rows = (
        _ROW_PX + _CELL_PX * (max(_lines([cell], most) for cell, most in zip(row, _CELL_LETTERS, strict=True)) - 1)
        for row in table.rows
    )
    return _HEADING_PX + _CAPTION_PX * _lines([table.caption], _CAPTION_LETTERS) + _ROW_PX + sum(rows)


def _end_px(pictures: object, rest: Points) -> float:
    figures = [figure.striptags() for figure in pictures.figures] if isinstance(pictures, PostureRow) else []
    height = max((_FIGURE_PX + _FIGURE_LINE_PX * _lines([text], _FIGURE_LETTERS) for text in figures), default=0)
    beside = _WIDTH_PX - _GAP_PX - len(figures) * (_FIGURE_WIDTH_PX + _FIGURE_GAP_PX) + _FIGURE_GAP_PX
    if figures and beside < _REST_LEAST_PX:
        half = (_WIDTH_PX - _GAP_PX) / 2 - _INDENT_PX
        return 2 * _HEADING_PX + height + _REST_PX * _lines(rest.items, half / _REST_LETTER_PX) / 2 + _REST_PX
    return _HEADING_PX + max(height, _REST_PX * _lines(rest.items, (beside - _INDENT_PX) / _REST_LETTER_PX))
