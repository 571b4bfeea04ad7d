"""`achse docs` writes the reference pages: every service row and every code of the tables."""

import importlib.util
import os
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from achse.cli.failure import fail
from achse.cli.files import write_file
from achse.cli.output import print_json
from achse.cli.target import Json
from achse.extras import needs_extra

if TYPE_CHECKING:
    from achse.server import Device, RowFacts
    from achse.st.tree import VarBlock

__all__ = ["reference_pages", "register"]


class Docs(TyperGroup):
    """`achse docs` and `achse docs nc` write pages, as `achse docs write nc` does."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if not args or (args[0] not in self.commands and args[0] not in ("-h", "--help")):
            args = ["write", *args]
        return super().parse_args(ctx, args)


def register(app: typer.Typer) -> None:
    """Add the commands of this module to `app`."""
    group = typer.Typer(cls=Docs, help="The documentation: reference pages, the site, one entry.")
    group.command()(write)
    for command in (build, serve, entry):
        group.command()(command)
    app.add_typer(group, name="docs")


def write(
    words: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[WORD]...", help="Only pages with such a word in their title: nc, plc, 10000."
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder to write to.")] = Path("docs"),
    in_json: Json = False,
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
        try:
            page.parent.mkdir(parents=True, exist_ok=True)
        except OSError as failure:
            fail(f"{page.parent}: {failure.strerror}", name="CANNOT_WRITE")
        write_file(page, text.encode())
        if not in_json:
            print(page)
    if in_json:
        print_json([{"file": str(out / name), "title": _title(text)} for name, text in wanted])


def build(
    out: Annotated[Path, typer.Option(help="Folder to write to.")] = Path(".site"),
) -> None:
    """Build the site from docs/ and the rows: MkDocs, in a clone. Needs the extra docs."""
    _mkdocs("build", "--strict", "--quiet", "--site-dir", str(out.absolute()))
    print(out)


def serve(
    host: Annotated[str, typer.Option(help="Address to listen at.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=1, max=65535, help="TCP port.")] = 8000,
) -> None:
    """Build the site, show it in a browser at http://host:port, and build what changes."""
    _mkdocs("serve", "--dev-addr", f"{host}:{port}")


def _mkdocs(*words: str) -> None:
    """Run MkDocs here; ends the command if it cannot."""
    if importlib.util.find_spec("mkdocs") is None:
        fail(needs_extra("the site", "docs"), name="NO_EXTRA")
    if not Path("mkdocs.yml").is_file():
        fail("no mkdocs.yml here: the site is built in a clone of the repository", name="NO_FILE")
    command = [sys.executable, "-m", "mkdocs", *words]
    ended = subprocess.run(command, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"}, check=False)
    if ended.returncode:
        fail(f"MkDocs ended with {ended.returncode}", name="FAILED")


def entry(
    code: Annotated[
        str,
        typer.Argument(metavar="ENTRY", help="A code or a name: 0x4655, 1861, MC_MoveAbsolute."),
    ],
    in_json: Json = False,
) -> None:
    """Show what a code or a name of a PLC library means, and where it is documented.

    With ACHSE_DOCS, the address of a site, it is a whole link.
    """
    from achse.codes import code_of
    from achse.codes.links import SITE, code_link, on_site

    try:
        number = int(code, 0)
    except ValueError:
        _library_entry(code, in_json)
        return
    link = code_link(number)
    found = code_of(number)
    if link is None or found is None:
        fail(f"no table has the code 0x{number:X}", name="NOT_FOUND")
    link = on_site(link, os.environ.get(SITE)) or link
    if in_json:
        print_json({"code": number, "name": found.name, "text": found.text, "link": link})
    else:
        print(f"0x{number:X}  {found.name}  {found.text}")
        print(link)


def _library_entry(name: str, in_json: bool) -> None:
    """Print what a name of a PLC library is."""
    from achse.codes.links import SITE, library_link, on_site
    from achse.iec.nearest import did_you_mean

    found = {
        row[0].strip("`"): (library, row)
        for library, rows in _library_rows().items()
        for row in rows
    }
    spelled = {known.casefold(): known for known in found}.get(name.casefold())
    if spelled is None:
        near = did_you_mean(name, found)
        fail(
            f"expected a code such as 0x4655, or a name of a PLC library, got {name!r:.40}{near}",
            name="NOT_FOUND",
        )
    library, (_, kind, meaning, inputs, outputs) = found[spelled]
    link = library_link(library, spelled)
    link = on_site(link, os.environ.get(SITE)) or link
    if in_json:
        document = {"name": spelled, "library": library, "kind": kind, "text": meaning}
        print_json(document | {"inputs": inputs, "outputs": outputs, "link": link})
        return
    print(f"{spelled}  {kind} of {library}  {meaning}".rstrip())
    for title, pins in (("inputs", inputs), ("outputs", outputs)):
        if pins:
            print(f"{title}: {pins}")
    print(link)


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
    for title, file, text in _library_pages():
        listed.append((title, file))
        yield f"reference/{file}", text
    title, file = "Words of part programs", "part-program-words.md"
    listed.append((title, file))
    yield f"reference/{file}", _page(title, ("word", "kind", "meaning"), _words(), WORDS)
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


def _words() -> Iterator[tuple[str, str, str]]:
    """The words of the dialect of part programs, each with its kind and meaning."""
    from achse.gcode.formula import FUNCTIONS
    from achse.gcode.words import ADDRESSES, AT_COMMANDS, G_WORDS, NAMED_WORDS, PATH_PARAMETERS

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


def _library_rows() -> dict[str, list[tuple[str, ...]]]:
    """Return name, kind, meaning, inputs and outputs of what each PLC library declares.

    Names with an underscore in front are internal.
    """
    from achse.st.standard import standard_libraries
    from achse.st.units import Function, FunctionBlock, TypeDeclaration

    libraries: dict[str, list[tuple[str, ...]]] = {}
    parts = list(standard_libraries())
    blocks = {
        unit.name.casefold(): unit
        for parsed in parts
        for unit in parsed.units
        if isinstance(unit, FunctionBlock)
    }

    def pins(unit: "Function | FunctionBlock", sections: tuple[str, ...]) -> str:
        """The variables that callers see, those of the block it extends first."""
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
    libraries = _library_rows()
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
    """The variables of a unit that callers see."""
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
