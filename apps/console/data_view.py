"""JSON values in a page: as a table where they are one, and as text."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

from nicegui import ui
from nicegui.element import Element

_MOST_ROWS = 200
_LARGE = 1e6  # from which on a number is shown with all digits before the point, such as a time
_LONGEST = 20_000  # characters of JSON that are shown


class DataTable(Element, component="data_table.js"):
    """A table; the browser makes the rows."""

    def __init__(self, titles: Sequence[str], empty: str) -> None:
        """Add it to the page. titles: of the columns. empty: shown in place of rows."""
        super().__init__()
        self._props["titles"] = list(titles)
        self._props["empty"] = empty

    def show(self, rows: Sequence[Sequence[str]], titles: Sequence[str] | None = None) -> None:
        """Show rows, and other titles if they are given."""
        if titles is not None:
            self._props["titles"] = list(titles)
        self._props["rows"] = [list(row) for row in rows]


class DataView:
    """Any JSON value in a page."""

    def __init__(self) -> None:
        """Add it to the page, empty."""
        with ui.element("div").classes("c-stack") as self._box:
            self._table = DataTable((), "empty")
            with ui.element("details") as self._details:
                with ui.element("summary"):
                    ui.label("JSON").classes("a-inline")
                self._text = ui.label("").classes("c-log")
        self.hide()

    def show(self, value: Any) -> None:
        """Show a value."""
        table = table_of(value)
        self._box.set_visibility(True)
        self._table.set_visibility(table is not None)
        if table is not None:
            self._table.show(table[1], table[0])
        self._details.props(remove="open") if table is not None else self._details.props("open")
        self._text.text = text_of(value)

    def hide(self) -> None:
        """Show nothing."""
        self._box.set_visibility(False)


def text_of(value: Any) -> str:
    """Return a value as indented JSON, cut where it is too long for a page."""
    text = json.dumps(value, ensure_ascii=False, indent=2)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}\n… {len(text) - _LONGEST} more characters"


def table_of(value: Any) -> tuple[list[str], list[list[str]]] | None:
    """Return titles and rows of a value: an object is a row for each of its fields, a list of objects a row for each.

    None for a value that is neither, or an empty one.
    """
    if isinstance(value, Mapping) and value:
        return ["Name", "Value"], [[str(key), _cell(each)] for key, each in list(value.items())[:_MOST_ROWS]]
    if isinstance(value, list) and value and all(isinstance(row, Mapping) for row in value):
        titles = list(dict.fromkeys(str(key) for row in value[:_MOST_ROWS] for key in row))
        return titles, [[_cell(row.get(title)) for title in titles] for row in value[:_MOST_ROWS]]
    return None


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.6g}" if abs(value) < _LARGE else f"{value:.3f}"
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
