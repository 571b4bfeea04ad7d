"""Features of the standard: the table of `tests/data/iec_features.toml`, as programs and as a page.

    python -m tests.st.edition

writes `docs/coverage/iec-61131-3.md`.
"""

import tomllib
from pathlib import Path
from typing import Any, NamedTuple

__all__ = ["FEATURES", "PAGE", "Feature", "page"]

_ROOT = Path(__file__).parents[2]
PAGE = _ROOT / "docs/coverage/iec-61131-3.md"
_STATUS = {"have": "have", "not": "have not", "vendor": "as the vendor's compiler"}
_HEAD = """# IEC 61131-3, feature by feature

Made by `python -m tests.st.edition` from `tests/data/iec_features.toml`; a test runs a small
program for each row. Numbers are those of the feature tables of edition 3 (2013), words are ours.
What edition 4 (2025) changed, as far as public sources say, is marked so: it drops instruction
lists and octal literals, which stay here, and adds functions of code units, which are not here.

*have*: the program runs and computes what the row says. *have not*: the program is refused, with
the reason. *as the vendor's compiler*: TwinCAT differs from the standard, and achse goes with
TwinCAT. Graphical languages have [their own page](graphical-bodies.md).

"""


class Feature(NamedTuple):
    """A feature and a program that uses it."""

    table: str
    name: str
    status: str
    note: str = ""
    units: str = ""
    declare: str = ""
    run: str = ""
    result: dict[str, Any] = {}  # noqa: RUF012 (a default of a tuple's field)

    @property
    def program(self) -> str:
        """The whole source."""
        return (
            f"{self.units}\nPROGRAM MAIN\nVAR\n{self.declare}\nEND_VAR\n{self.run}\nEND_PROGRAM\n"
        )


FEATURES = tuple(
    Feature(**row)
    for row in tomllib.loads((_ROOT / "tests/data/iec_features.toml").read_text())["feature"]
)


def page() -> str:
    """The table as a page."""
    counts = {key: sum(one.status == key for one in FEATURES) for key in _STATUS}
    summary = ", ".join(f"{count} {_STATUS[key]}" for key, count in counts.items())
    lines = [f"{len(FEATURES)} rows: {summary}.", "", "| table | feature | state | note |"]
    lines.append("| --- | --- | --- | --- |")
    for one in FEATURES:
        name, note = (text.replace("|", "\\|") for text in (one.name, one.note))
        lines.append(f"| {one.table} | {name} | {_STATUS[one.status]} | {note} |")
    return _HEAD + "\n".join(lines) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page())
