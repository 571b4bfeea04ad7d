"""Reference pages as Markdown: every service row, every code, object, block and word.

They are made from the rows when the site is built or `achse docs` writes them; none is in git.
"""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from achse.site.findings import finding_pages

if TYPE_CHECKING:
    from achse.server import Device, RowFacts
    from achse.st.syntax.tree import VarBlock


def reference_pages(devices: Iterable["Device"]) -> Iterator[tuple[str, str]]:
    """Path and Markdown text of each page: one per device, the codes, what is covered."""
    from achse.codes import NcError, ReturnCode
    from achse.codes.nc.table import GROUPS
    from achse.codes.remedies import remedy_of
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
                    GROUPS[service.index_group].clause,
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
        lines = [
            (f"0x{code:X}", str(code), f"`{name}`", _text(text), _text(remedy_of(code)))
            for code, name, text in table
        ]
        yield f"reference/{file}", _page(title, CODE_COLUMNS, lines)
    for title, file, text in (*_bus_code_pages(), *_drive_pages()):
        listed.append((title, file))
        yield f"reference/{file}", text
    for title, file, text in _library_pages():
        listed.append((title, file))
        yield f"reference/{file}", text
    for title, file, text in finding_pages(GENERATED):
        listed.append((title, file))
        yield f"reference/{file}", text
    title, file = "Words of part programs", "part-program-words.md"
    listed.append((title, file))
    yield f"reference/{file}", _page(title, ("word", "kind", "meaning"), _words(), WORDS)
    links = "".join(f"- [{title}]({file})\n" for title, file in listed)
    yield ALL_PAGES, f"# All reference pages\n\n{GENERATED}\n\n{links}"


CODE_COLUMNS = ("hex", "decimal", "name", "meaning", "remedy")

ALL_PAGES = "reference/all.md"
"""Page that lists the others."""


def _bus_code_pages() -> Iterator[tuple[str, str, str]]:
    """Title, file and text of the pages about codes that slaves report to their master."""
    from achse.codes import AbortCode, AlStatus

    columns = ("hex", "name", "meaning")
    aborts = [(f"0x{each.number:08X}", f"`{each.name}`", _text(each.text)) for each in AbortCode]
    yield "SDO abort codes", "sdo-aborts.md", _page("SDO abort codes", columns, aborts)
    states = [(f"0x{each.number:X}", f"`{each.name}`", _text(each.text)) for each in AlStatus]
    yield "AL status codes", "al-status.md", _page("AL status codes", columns, states)


def _drive_pages() -> Iterator[tuple[str, str, str]]:
    """Title, file and text of the pages about the virtual drive."""
    from achse.drive import Alarm, Warn
    from achse.drive.objects import ROWS
    from achse.site.objects import object_cells

    title, file = "Objects of the virtual drive", "drive-objects.md"
    objects = [(*map(_text, object_cells(row)), _text(row.doc)) for row in ROWS]
    yield title, file, _page(title, OBJECT_COLUMNS, objects, OBJECTS)
    title, file = "Alarms and warnings of the virtual drive", "drive-alarms.md"
    lines = [(alarm.panel, f"603Fh 0x{alarm.code:X}", _text(alarm.text)) for alarm in Alarm]
    lines += [(each.panel, f"{each.index:X}h bit {each.bit}", _text(each.text)) for each in Warn]
    yield title, file, _page(title, ("panel", "shown in", "meaning"), lines)


def _words() -> Iterator[tuple[str, str, str]]:
    """Return the words of the dialect of part programs, each with its kind and meaning."""
    from achse.gcode.text.formula import FUNCTIONS
    from achse.gcode.text.words import ADDRESSES, AT_COMMANDS, G_WORDS, NAMED_WORDS, PATH_PARAMETERS

    for word in (*G_WORDS.values(), *NAMED_WORDS.values()):
        alone = "; in a block of its own" if word.alone else ""
        yield f"`{word.name}`", _text(word.group.value), _text(f"{word.meaning}{alone}")
    for letter, meaning in ADDRESSES.items():
        yield f"`{letter}`", "address", _text(meaning)
    for row in AT_COMMANDS.values():
        yield f"`@{row.number}`", "flow", _text(f"{row.meaning}; operands: {row.form.value}")
    for name in FUNCTIONS:
        yield f"`{name}`", "function of formulas", "angles in degrees"
    for parameter in PATH_PARAMETERS.values():
        yield f"`#set {parameter.name}(…)#`", "path", _text(parameter.parameter.value)


def library_rows() -> dict[str, list[tuple[str, ...]]]:
    """Return name, kind, meaning, inputs and outputs of what each PLC library declares.

    Names with an underscore in front are internal.
    """
    from achse.st.declared.standard import standard_libraries
    from achse.st.syntax.units import Function, FunctionBlock, TypeDeclaration

    libraries: dict[str, list[tuple[str, ...]]] = {}
    parts = list(standard_libraries())
    blocks = {
        unit.name.casefold(): unit
        for parsed in parts
        for unit in parsed.units
        if isinstance(unit, FunctionBlock)
    }

    def pins(unit: "Function | FunctionBlock", sections: tuple[str, ...]) -> str:
        """Return the variables that callers see, those of the block it extends first."""
        names = [*_names_of(unit.blocks, sections)]
        base = unit.extends if isinstance(unit, FunctionBlock) else None
        while base is not None:
            above = blocks[base.name.casefold()]
            names = [*_names_of(above.blocks, sections), *names]
            base = above.extends
        return ", ".join(names)

    for parsed in parts:
        rows = libraries.setdefault(parsed.source.path.partition("/")[0], [])
        heading = parsed.source.text.partition("\n\n")[0].replace("//", "")
        for unit in parsed.units:
            if not isinstance(unit, TypeDeclaration | Function | FunctionBlock):
                continue
            if unit.name.startswith("_"):
                continue
            meaning = _text(unit.note.comment).removeprefix(_text(heading)).strip()
            if isinstance(unit, TypeDeclaration):
                rows.append((f"`{unit.name}`", "type", meaning, "", ""))
                continue
            kind = "function" if isinstance(unit, Function) else "function block"
            built_in = any(name == "builtin" for name, _ in unit.note.attributes)
            inputs, outputs = pins(unit, ("VAR_INPUT", "VAR_IN_OUT")), pins(unit, ("VAR_OUTPUT",))
            kind += " (built in)" if built_in else ""
            rows.append((f"`{unit.name}`", kind, meaning, inputs, outputs))
    return libraries


def _library_pages() -> Iterator[tuple[str, str, str]]:
    """Title, file and text of the pages about the PLC libraries; the first lists them."""
    libraries = library_rows()
    listed = [
        (f"[{name}](plc-library-{name}.md)", str(len(rows))) for name, rows in libraries.items()
    ]
    title, file = "PLC libraries", "plc-libraries.md"
    yield title, file, _page(title, ("library", "names"), sorted(listed), LIBRARIES)
    for name, rows in sorted(libraries.items()):
        title = f"PLC library {name}"
        rows.sort(key=lambda row: row[0].lower())
        yield title, f"plc-library-{name}.md", _page(title, LIBRARY_COLUMNS, rows)


def _names_of(blocks: Iterable["VarBlock"], sections: tuple[str, ...]) -> Iterator[str]:
    """Return the variables of a unit that callers see."""
    return (
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
LIBRARY_COLUMNS = ("name", "kind", "meaning", "inputs", "outputs")

WORDS = (
    "What a part program (DIN 66025, the classic dialect) may say. Formulas are worked out from"
    " left to right; `R0` to `R999` are parameters, `P5` is the parameter whose number R5 holds, K"
    " a constant. Other words are refused.\n\n"
)

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
    " [here](../coverage/drive-choices.md). `achse drive objects` shows the range of an entry.\n\n"
)
OBJECT_COLUMNS = ("index", "type", "access", "pdo", "default", "unit", "name", "meaning")

COVERAGE_COLUMNS = ("index group", "offset", "access", "name", "clause", "answer")


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
