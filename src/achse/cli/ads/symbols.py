"""`achse symbols` carries symbols between PLCs, symbol files and Python."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.files import write_file
from achse.cli.output import print_json, print_table
from achse.cli.target import Json, client_command, fail_to_connect

if TYPE_CHECKING:
    from achse.client import Target
    from achse.st.symbolfiles import SymbolFile

__all__ = ["symbols"]

PLC_PORT = 851

_ROOTS = {".tmc": b"<TcModuleClass", ".tpy": b"<PlcProjectInfo"}
"""Beginning of symbol files, by the ending of their names."""

_STUBS = b"written by `achse symbols stubs`"
"""Beginning of modules that this command writes."""

_HEAD = 4096
"""Bytes at the begin of a file that tell what it is."""

symbols = typer.Typer(
    no_args_is_help=True, help="Symbols of a PLC: write and read .tmc files, compare, type."
)

Origin = Annotated[
    Path, typer.Argument(help="A .tmc or .tpy file, or a folder or file of Structured Text.")
]


@client_command(symbols, PLC_PORT)
async def export(
    client: "Target",
    file: Annotated[Path, typer.Argument(help="The .tmc or .tpy file to write.")],
    in_json: Json = False,
) -> None:
    """Write the symbols and types of a running PLC as a .tmc or .tpy file."""
    _check_ending(file, "FILE")
    found = await _of_target(client, file.stem)
    _write_symbols(file, found)
    variables, types = len(found.variables), len(found.types)
    if in_json:
        print_json({"file": str(file), "variables": variables, "types": types})
    else:
        print(f"{file}: {variables} variables, {types} types")


@symbols.command("import")
def import_(
    origin: Origin,
    to: Annotated[
        Path | None,
        typer.Option("--to", help="Write a station.toml that serves them, or a .tmc or .tpy."),
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(min=1, max=65535, help="AMS port of the PLC.", show_default="as in the file"),
    ] = None,
    in_json: Json = False,
) -> None:
    """Read symbols from sources or a symbol file: what is in there, and a station with them."""
    if to is not None:
        _check_ending(to, "--to", ".toml")
    found = _of_origin(origin)
    number = port or found.port
    if to is not None:
        if to.suffix.lower() == ".toml":
            if to.exists():
                fail(f"{to} exists already: add this to it\n{_plc_table(origin, to, number)}")
            write_file(to, _plc_table(origin, to, number).encode())
        else:
            _write_symbols(to, found)
    facts = {
        "name": found.name,
        "port": number,
        "tasks": [task.name for task in found.tasks],
        "variables": len(found.variables),
        "types": len(found.types),
    }
    if in_json:
        print_json(facts)
        return
    shown = {**facts, "tasks": ", ".join(task.name for task in found.tasks)}
    print_table([(name, str(value)) for name, value in shown.items()])


@symbols.command("stand-ins")
def stand_ins(
    sources: Annotated[
        Path, typer.Argument(help="A folder with PLC sources, a .plcproj, one source file.")
    ],
    to: Annotated[Path, typer.Option("--to", help="The folder to write to.")] = Path("stand-ins"),
    library: Annotated[
        list[Path] | None,
        typer.Option(help="Sources or .tmc of a library that is there, once for each."),
    ] = None,
    in_json: Json = False,
) -> None:
    """Write declarations for what sources name and nothing declares.

    Types, constants and functions have the members, values and inputs that the sources use. What
    no use tells is guessed and has a question mark: fill it in, and name the folder in `libraries`.
    """
    from achse.st.project import examine_project
    from achse.st.source import SourceError
    from achse.st.unknown import MissingNames
    from achse.st.unknown import stand_ins as written

    try:
        project, _ = examine_project(sources, libraries=library or [])
    except SourceError as fault:
        fail(str(fault))
    files = {
        to / name: text for name, text in written(MissingNames(project.declarations.names)).items()
    }
    for file in files:
        if file.exists():
            fail(f"{file} exists already: name another folder by --to")
    if files:
        _make_folder(to)
    for file, text in files.items():
        try:
            file.write_text(text)
        except OSError as failure:
            fail(f"{file}: {failure.strerror}")
    found = {str(file): text.count("\n") for file, text in files.items()}
    if in_json:
        print_json(found)
        return
    for name, lines in found.items():
        print(f"{name}: {lines} lines")
    print(f'libraries = ["{to.as_posix()}"]' if found else "nothing is missing")


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as failure:
        fail(f"{folder}: {failure.strerror}")


@symbols.command()
def diff(
    old: Annotated[Path, typer.Argument(help="Symbol file or sources; - is the running PLC.")],
    new: Annotated[Path, typer.Argument(help="Symbol file or sources; - is the running PLC.")],
    places: Annotated[
        bool, typer.Option("--places/--no-places", help="Compare addresses as well.")
    ] = False,
    port: Annotated[
        int, typer.Option(min=1, max=65535, help="AMS port of the running PLC.")
    ] = PLC_PORT,
    in_json: Json = False,
) -> None:
    """Compare types and variables; exit code 1 if they differ.

    The running PLC is at ACHSE_HOST and ACHSE_TCP_PORT, else on this host.
    """
    from achse.st.symbolfiles import differences

    first, second = (
        _of_running(port) if str(origin) == "-" else _of_origin(origin) for origin in (old, new)
    )
    changes = differences(first, second, places=places)
    if in_json:
        print_json([change._asdict() for change in changes])
    else:
        for change in changes:
            print(change)
    if changes:
        raise typer.Exit(1)


@client_command(symbols, PLC_PORT)
async def stubs(
    client: "Target",
    pattern: Annotated[
        str, typer.Argument(help="Names like GVL.*; a plain name takes its members.")
    ] = "*",
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The Python file.", show_default="stdout")
    ] = None,
    in_json: Json = False,
) -> None:
    """Write a Python module with types for a PLC's symbols and methods."""
    from achse.cli.ads.selection import selected
    from achse.client.stubs import programs_of, stubs

    types = await client.types()
    chosen = {
        entry.name: types.symbol_type(entry) for entry in selected(await client.symbols(), pattern)
    }
    text = stubs(chosen, str(client.address), await programs_of(client, chosen))
    if output is None and in_json:
        print_json({"module": text, "symbols": len(chosen)})
    elif output is None:
        print(text, end="")
    else:
        write_file(
            output, text.encode(), lambda there: _STUBS in there[:_HEAD], "made by this command"
        )
        if in_json:
            print_json({"file": str(output), "symbols": len(chosen)})
        else:
            print(f"{output}: {len(chosen)} symbols")


async def _of_target(client: "Target", name: str) -> "SymbolFile":
    from achse.st.symbolfiles import SymbolFile

    types = await client.types()
    return SymbolFile.of_target(
        name,
        await client.symbols(),
        types,
        port=client.address.port,
        pointer_size=types.pointer_size,
    )


def _of_running(port: int) -> "SymbolFile":
    from achse.ams import AdsError
    from achse.cli.interrupts import Interrupted, run
    from achse.client import connect

    async def ask() -> "SymbolFile":
        async with connect(port=port, reconnect=False, watch_symbols=False) as client:
            return await _of_target(client, str(client.address))

    try:
        return run(ask())
    except AdsError as refusal:
        fail_to_connect(refusal, os.environ.get("ACHSE_HOST", "127.0.0.1"), 0)
    except Interrupted as interrupted:
        raise typer.Exit(interrupted.exit_code) from None


def _of_origin(origin: Path) -> "SymbolFile":
    """Return the symbols that sources or a symbol file declare."""
    from achse.station import ConfigError
    from achse.station.configuration.station_file import PlcConfig
    from achse.station.plcs.sources import PlcSource

    if origin.suffix.lower() == ".toml":
        fail(
            f"{origin}: a station is described there, no symbols: name the sources or the symbol"
            " file that its [[plc]] names, or a running station by `achse symbols export`"
        )
    if origin.suffix.lower() in (".tmc", ".tpy"):
        from achse.iec import DeclarationError
        from achse.st.symbolfiles import read_symbol_file

        try:
            return read_symbol_file(origin.read_bytes(), str(origin))
        except OSError as failure:
            fail(f"{origin}: {failure.strerror}")
        except DeclarationError as fault:
            fail(str(fault))
    from achse.plc.symbol_file import symbol_file

    config: dict[str, Any] = {"sources": str(origin.resolve())}
    try:
        return symbol_file(PlcSource(PlcConfig(**config), str(origin), Path()).make())
    except ConfigError as fault:
        fail(str(fault).removeprefix(f"{origin}.sources: "))


def _plc_table(origin: Path, to: Path, port: int) -> str:
    """The `[[plc]]` table for a station.toml beside which `origin` lies."""
    key = "symbols" if origin.suffix.lower() in (".tmc", ".tpy") else "sources"
    try:
        path = origin.resolve().relative_to(to.resolve().parent)
    except ValueError:
        path = origin.resolve()
    text = str(path).replace("\\", "/").replace('"', '\\"')
    return f'[[plc]]\nport = {port}\n{key} = "{text}"\n'


def _check_ending(file: Path, option: str, *others: str) -> None:
    """Refuse a name whose ending says another kind of file: it could be somebody's source."""
    endings = (*others, *_ROOTS)
    if file.suffix.lower() not in endings:
        listed = f"{', '.join(endings[:-1])} or {endings[-1]}"
        raise typer.BadParameter(
            f"a file that ends in {listed}, got {str(file)!r}", param_hint=option
        )


def _write_symbols(file: Path, found: "SymbolFile") -> None:
    """Write a symbol file as its ending says, over none but one of the same kind."""
    from achse.st.symbolfiles import write_symbol_file

    root = _ROOTS[file.suffix.lower()]
    write_file(
        file,
        write_symbol_file(found, file.name),
        lambda there: root in there[:_HEAD],
        f"a {file.suffix} file",
    )
