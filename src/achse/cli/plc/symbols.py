"""`achse symbols` lists the symbols of PLCs, sources and symbol files, and writes them."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from achse.cli.failure import fail
from achse.cli.files import write_file
from achse.cli.output import print_json, print_table
from achse.cli.plc.selection import selected
from achse.cli.target import Json, client_command, fail_to_connect

if TYPE_CHECKING:
    from achse.client import Client, Target
    from achse.st.symbolfiles import SymbolFile

PLC_PORT = 851

_ROOTS = {".tmc": b"<TcModuleClass", ".tpy": b"<PlcProjectInfo"}
"""Beginning of symbol files, by the ending of their names."""

_STUBS = b"written by `achse symbols`"
"""Beginning of modules that this command writes."""

_HEAD = 4096
"""Bytes at the begin of a file that identify its kind."""

_PRINTED = Path("-")


def register(app: typer.Typer) -> None:
    """Add the command of this module to `app`."""
    client_command(app, PLC_PORT, alone=lambda options: options["origin"] is not None)(symbols)


async def symbols(
    client: "Client | None",
    pattern: Annotated[
        str, typer.Argument(help="Names like GVL.* or *counter; a plain name takes its members.")
    ] = "*",
    type_pattern: Annotated[str, typer.Option("--type", help="Types like INT or ARRAY*.")] = "*",
    origin: Annotated[
        Path | None,
        typer.Option(
            "--from",
            metavar="FILE",
            help="A .tmc or .tpy, or a folder or file of Structured Text.",
            show_default="the running PLC",
        ),
    ] = None,
    to: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Write them: .tmc, .tpy; with --from a station.toml; from a running PLC a Python"
            " module with types (.py, - prints it).",
            show_default="list them",
        ),
    ] = None,
    station_port: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=65535,
            help="AMS port of the PLC in the station.toml.",
            show_default="as in the file",
        ),
    ] = None,
    in_json: Json = False,
) -> None:
    """List the symbols of a PLC with type, size and place, or write them to a file."""
    if origin is not None:
        _symbols_of_file(origin, to, pattern, type_pattern, station_port, in_json)
        return
    assert client is not None
    if to is None:
        await _list(client, pattern, type_pattern, in_json)
    elif to == _PRINTED or to.suffix.lower() == ".py":
        await _write_stubs(client, pattern, to, in_json)
    else:
        _check_ending(to, ".py")
        symbol_file = await _of_target(client, to.stem)
        _write_symbols(to, symbol_file)
        variables, types = len(symbol_file.variables), len(symbol_file.types)
        if in_json:
            print_json({"file": str(to), "variables": variables, "types": types})
        else:
            print(f"{to}: {variables} variables, {types} types")


async def _list(client: "Client", pattern: str, type_pattern: str, in_json: bool) -> None:
    """Print the symbols of a device."""
    chosen = list(selected(await client.symbols(), pattern, type_pattern))
    if in_json:
        print_json(
            [
                {
                    "name": entry.name,
                    "type": entry.type_name,
                    "size": entry.size,
                    "index_group": entry.index_group,
                    "index_offset": entry.index_offset,
                    "comment": entry.comment,
                }
                for entry in chosen
            ]
        )
    elif chosen:
        print_table(
            [
                (
                    entry.name,
                    entry.type_name,
                    f"0x{entry.index_group:X}:0x{entry.index_offset:X}",
                    str(entry.size),
                    entry.comment,
                )
                for entry in chosen
            ],
            right=frozenset({3}),
        )


async def _write_stubs(client: "Client", pattern: str, to: Path, in_json: bool) -> None:
    """Write a Python module with types for a PLC's symbols and methods."""
    from achse.client.stubs import programs_of, stubs

    types = await client.types()
    chosen = {
        entry.name: types.symbol_type(entry) for entry in selected(await client.symbols(), pattern)
    }
    text = stubs(chosen, str(client.address), await programs_of(client, chosen))
    if to == _PRINTED and in_json:
        print_json({"module": text, "symbols": len(chosen)})
    elif to == _PRINTED:
        print(text, end="")
    else:
        write_file(to, text.encode(), lambda there: _STUBS in there[:_HEAD], "made by this command")
        if in_json:
            print_json({"file": str(to), "symbols": len(chosen)})
        else:
            print(f"{to}: {len(chosen)} symbols")


def _symbols_of_file(
    origin: Path,
    to: Path | None,
    pattern: str,
    type_pattern: str,
    port: int | None,
    in_json: bool,
) -> None:
    """List the symbols of sources or of a symbol file, or write a station.toml or a symbol file."""
    if to is not None:
        _check_ending(to, ".toml")
    symbol_file = _of_origin(origin)
    if to is None:
        rows = [
            (each.name, each.type_name)
            for each in selected(_listed(symbol_file), pattern, type_pattern)
        ]
        if in_json:
            print_json([{"name": name, "type": type} for name, type in rows])
        elif rows:
            print_table(rows)
        return
    number = port or symbol_file.port
    if to.suffix.lower() == ".toml":
        if to.exists():
            fail(f"{to} exists already: add this to it\n{_plc_table(origin, to, number)}")
        write_file(to, _plc_table(origin, to, number).encode())
    else:
        _write_symbols(to, symbol_file)
    facts = {
        "name": symbol_file.name,
        "port": number,
        "tasks": [task.name for task in symbol_file.tasks],
        "variables": len(symbol_file.variables),
        "types": len(symbol_file.types),
    }
    if in_json:
        print_json(facts)
        return
    shown = {**facts, "tasks": ", ".join(task.name for task in symbol_file.tasks)}
    print_table([(name, str(value)) for name, value in shown.items()])


class _Listed(NamedTuple):
    """Name and type of a variable in a file."""

    name: str
    type_name: str


def _listed(symbol_file: "SymbolFile") -> list[_Listed]:
    """Return the variables of a file by name and type."""
    return [_Listed(each.name, each.declared.type.name) for each in symbol_file.variables]


def report_differences(old: Path, new: Path, places: bool, port: int, in_json: bool) -> None:
    """Print the differences of types and variables; exit code 1 if there are any.

    `-` is the running PLC at ACHSE_HOST and ACHSE_TCP_PORT.
    """
    from achse.st.symbolfiles import differences

    first, second = (
        _of_running(port) if origin == _PRINTED else _of_origin(origin) for origin in (old, new)
    )
    changes = differences(first, second, places=places)
    if in_json:
        print_json([change._asdict() for change in changes])
    else:
        for change in changes:
            print(change)
    if changes:
        raise typer.Exit(1)


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

    async def query() -> "SymbolFile":
        async with connect(port=port, reconnect=False, watch_symbols=False) as client:
            return await _of_target(client, str(client.address))

    try:
        return run(query())
    except AdsError as refusal:
        fail_to_connect(refusal, os.environ.get("ACHSE_HOST", "127.0.0.1"), 0)
    except Interrupted as interrupted:
        raise typer.Exit(interrupted.exit_code) from None


def _of_origin(origin: Path) -> "SymbolFile":
    """Return the symbols that sources or a symbol file declare."""
    from achse.st.files.forms import Content, has_content
    from achse.station import ConfigError
    from achse.station.configuration.plc import PlcConfig
    from achse.station.plcs.sources import PlcSource

    if origin.suffix.lower() == ".toml":
        fail(
            f"{origin}: a station is described there, no symbols: name the sources or the symbol"
            " file that its [[plc]] names, or ask a running station by `achse symbols`"
        )
    if has_content(origin, Content.SYMBOLS):
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
    """Return the `[[plc]]` table for a station.toml beside `origin`."""
    from achse.st.files.forms import Content, has_content

    key = "symbols" if has_content(origin, Content.SYMBOLS) else "sources"
    try:
        path = origin.resolve().relative_to(to.resolve().parent)
    except ValueError:
        path = origin.resolve()
    text = str(path).replace("\\", "/").replace('"', '\\"')
    return f'[[plc]]\nport = {port}\n{key} = "{text}"\n'


def _check_ending(file: Path, *others: str) -> None:
    """Refuse a name whose ending says another kind of file: it could be a source of the user."""
    endings = (*others, *_ROOTS)
    if file.suffix.lower() not in endings:
        listed = f"{', '.join(endings[:-1])} or {endings[-1]}"
        raise typer.BadParameter(
            f"a file that ends in {listed}, got {str(file)!r}", param_hint="--to"
        )


def _write_symbols(file: Path, symbol_file: "SymbolFile") -> None:
    """Write a symbol file as its ending says, over none but one of the same kind."""
    from achse.st.symbolfiles import write_symbol_file

    root = _ROOTS[file.suffix.lower()]
    write_file(
        file,
        write_symbol_file(symbol_file, file.name),
        lambda there: root in there[:_HEAD],
        f"a {file.suffix} file",
    )
