"""The page has the lines of the project, marked by what has run."""

from html.parser import HTMLParser

from achse.plc.coverage.html import page_of
from achse.plc.coverage.results import CoverageResult
from tests.plc.coverage.conftest import COUNTED


class _Rows(HTMLParser):
    """Rows of code: their class and cells."""

    def __init__(self) -> None:
        super().__init__()
        self.rows: list[tuple[str, list[str]]] = []
        self._in_cell = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "tr":
            self.rows.append((dict(attrs).get("class") or "", []))
        if tag == "td":
            self.rows[-1][1].append("")
            self._in_cell = True

    def handle_endtag(self, tag: str) -> None:
        self._in_cell = self._in_cell and tag != "td"

    def handle_data(self, data: str) -> None:
        if self._in_cell:
            self.rows[-1][1][-1] += data


def test_the_page_has_the_lines_of_the_project(result: CoverageResult) -> None:
    reader = _Rows()
    reader.feed(page_of(result))
    source = COUNTED.read_text(encoding="utf-8").splitlines()
    shown = {int(row[0]): (kind, row) for kind, row in reader.rows if row and row[0].isdigit()}
    assert [row[2] for _, row in shown.values()] == source
    for number, hits in result.files[0].lines.items():
        kind, row = shown[number]
        assert row[1] == str(hits)
        assert (kind == "missed") is (hits == 0)
