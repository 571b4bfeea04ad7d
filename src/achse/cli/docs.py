"""`achse docs` writes the reference pages: every service row and every code of the tables."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from achse.cli.run import fail

if TYPE_CHECKING:
    from achse.server import Device, RowFacts
    from achse.st.tree import VarBlock

__all__ = ["reference_pages", "register"]


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    app.command()(docs)


def docs(
    words: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[WORD]...", help="Only pages with such a word in their title: nc, plc, 10000."
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder to write to.")] = Path("docs"),
) -> None:
    """Write the reference pages of the demo station's devices and of all codes."""
    from achse.station import Station

    pages = list(reference_pages(Station.demo().devices))
    wanted = [page for page in pages if not words or _is_about(page[1], words)]
    if not wanted:
        titles = "; ".join(_title(text) for _, text in pages)
        fail(f"no page about {' or '.join(words or ())}; there are: {titles}")
    for name, text in wanted:
        page = out / name
        page.parent.mkdir(parents=True, exist_ok=True)
        page.write_text(text, encoding="utf-8")
        print(page)


def _title(page: str) -> str:
    return page.partition("\n")[0].removeprefix("# ")


def _is_about(page: str, words: list[str]) -> bool:
    """Whether a word of the title begins so."""
    title = _title(page).lower().split()
    return any(part.startswith(word.lower()) for part in title for word in words)


def reference_pages(devices: Iterable["Device"]) -> Iterator[tuple[str, str]]:
    """Path and Markdown text of each page: one per device, the codes, what is covered."""
    from achse.codes import NcError, ReturnCode
    from achse.devices.nc import NcDevice
    from achse.devices.nc.coverage import coverage

    listed = []
    for device in sorted(devices, key=lambda device: device.address.port):
        port, *also = (address.port for address in device.addresses)
        title = f"Services of {device.name}: port {' and '.join(map(str, (port, *also)))}"
        rows = [_service(row) for row in device.services.describe()]
        listed.append((title, f"services-{port}.md"))
        yield f"reference/services-{port}.md", _page(title, SERVICE_COLUMNS, rows)
        if isinstance(device, NcDevice):
            title = f"Coverage of the services of {device.name}"
            listed.append((title, "../coverage/nc.md"))
            services = [
                (
                    f"0x{service.index_group:04X}",
                    f"0x{service.index_offset:08X}",
                    service.access,
                    f"`{service.name}`",
                    _text(service.answer),
                )
                for service in coverage(device.services.describe())
            ]
            yield "coverage/nc.md", _page(title, COVERAGE_COLUMNS, services, COVERAGE)
    codes: tuple[tuple[str, str, Iterable[tuple[int, str, str]]], ...] = (
        (
            "ADS return codes",
            "return-codes.md",
            ((code.number, code.vendor_name, code.text) for code in ReturnCode),
        ),
        (
            "NC error codes",
            "nc-errors.md",
            ((code.number, code.name, code.text) for code in NcError),
        ),
    )
    for title, file, table in codes:
        listed.append((title, file))
        lines = [(f"0x{code:X}", str(code), f"`{name}`", _text(text)) for code, name, text in table]
        yield f"reference/{file}", _page(title, ("hex", "decimal", "name", "meaning"), lines)
    for title, file, text in _drive_pages():
        listed.append((title, file))
        yield f"reference/{file}", text
    title, file, text = _library_page()
    listed.append((title, file))
    yield f"reference/{file}", text
    links = "".join(f"- [{title}]({file})\n" for title, file in listed)
    yield "reference/index.md", f"# Reference\n\n{GENERATED}\n\n{links}"


def _drive_pages() -> Iterator[tuple[str, str, str]]:
    """Title, file and text of the pages about the virtual drive."""
    from achse.cli.objects import line_of
    from achse.drive import Alarm, Warn
    from achse.drive.objects import ROWS

    title, file = "Objects of the virtual drive", "drive-objects.md"
    objects = [(*map(_text, line_of(row)), _text(row.doc)) for row in ROWS]
    yield title, file, _page(title, OBJECT_COLUMNS, objects, OBJECTS)
    title, file = "Alarms and warnings of the virtual drive", "drive-alarms.md"
    lines = [(alarm.panel, f"603Fh 0x{alarm.code:X}", _text(alarm.text)) for alarm in Alarm]
    lines += [(each.panel, f"{each.index:X}h bit {each.bit}", _text(each.text)) for each in Warn]
    yield title, file, _page(title, ("panel", "shown in", "meaning"), lines)


def _library_page() -> tuple[str, str, str]:
    """Title, file and text of the page about the PLC libraries, from their sources."""
    from achse.st.standard import standard_libraries
    from achse.st.units import Function, FunctionBlock, TypeDeclaration

    rows = []
    for parsed in standard_libraries():
        library = parsed.source.path.partition("/")[0]
        for unit in parsed.units:
            if isinstance(unit, TypeDeclaration):
                rows.append((library, f"`{unit.name}`", "type", "", ""))
            elif isinstance(unit, Function | FunctionBlock):
                kind = "function" if isinstance(unit, Function) else "function block"
                built_in = any(name == "builtin" for name, _ in unit.note.attributes)
                inputs = _names_of(unit.blocks, ("VAR_INPUT", "VAR_IN_OUT"))
                outputs = _names_of(unit.blocks, ("VAR_OUTPUT",))
                kind += " (built in)" if built_in else ""
                rows.append((library, f"`{unit.name}`", kind, inputs, outputs))
    rows.sort(key=lambda row: (row[0], row[1].lower()))
    title, file = "PLC libraries", "plc-libraries.md"
    return title, file, _page(title, LIBRARY_COLUMNS, rows, LIBRARIES)


def _names_of(blocks: Iterable["VarBlock"], sections: tuple[str, ...]) -> str:
    """The variables of a unit that callers see."""
    return ", ".join(
        name.name
        for block in blocks
        if block.section in sections
        for variable in block.variables
        for name in variable.names
    )


LIBRARIES = (
    "What a PLC project can name without sources of its own. All of it is Structured Text"
    " (`achse.libraries`) but what is marked as built in. The functions of texts (LEN, CONCAT,"
    " WLEN …), conversions and operators are the language's own.\n\n"
)
LIBRARY_COLUMNS = ("library", "name", "kind", "inputs", "outputs")

GENERATED = "Generated from the rows in the code by `achse docs`; edit those, not this page."

SERVICE_COLUMNS = ("index group", "offset", "access", "data", "unit", "range", "name", "meaning")

COVERAGE = (
    "Every service that the manual lists for ring 0, channels, groups, axes, encoders, controllers,"
    " drives and tables (002 §6.4), and what comes of it. Numbers are those of the first axis,"
    " element and object."
    " Where the manual leaves a choice, ours is [here](nc-choices.md).\n\n"
)
OBJECTS = (
    "The object dictionary (001 §3). Where the manual leaves a choice, ours is"
    " [here](../coverage/drive-choices.md). `achse drive show` tells the range of an entry.\n\n"
)
OBJECT_COLUMNS = ("index", "type", "access", "pdo", "default", "unit", "name", "meaning")

COVERAGE_COLUMNS = ("index group", "offset", "access", "name", "answer")


def _page(
    title: str, columns: Iterable[str], rows: Iterable[Iterable[str]], preface: str = ""
) -> str:
    columns = tuple(columns)
    lines = [columns, ["---"] * len(columns), *rows]
    table = "".join("| " + " | ".join(line) + " |\n" for line in lines)
    return f"# {title}\n\n{GENERATED}\n\n{preface}{table}"


def _service(row: "RowFacts") -> Iterable[str]:
    data = f"{row.layout} → {row.response_layout}" if row.response_layout else row.layout
    meaning = row.description
    if row.symbol:
        meaning += f" Symbol `{row.symbol}`."
    if row.source:
        meaning += f" ({row.source})"
    return (
        _range(row.index_group, row.last_index_group, 4),
        _range(row.index_offset, row.last_index_offset, 8),
        str(row.access),
        _text(data),
        _text(row.unit),
        _text(row.range),
        f"`{row.name}`",
        _text(meaning),
    )


def _range(first: int, last: int, digits: int) -> str:
    low, high = f"0x{first:0{digits}X}", f"0x{last:0{digits}X}"
    return low if first == last else f"{low} … {high}"


def _text(text: str) -> str:
    """Text as it may be in a table cell."""
    return " ".join(text.split()).replace("|", "\\|")
