"""`achse symbols` carries symbols between PLCs, symbol files and Python."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.output import print_json, print_table
from achse.cli.run import fail
from achse.cli.target import STATION_PORT, Json, client_command

if TYPE_CHECKING:
    from achse.client import Target
    from achse.st.symbolfiles import SymbolFile

__all__ = ["symbols"]

PLC_PORT = 851
LONGEST_ANSWER = 1 << 16

symbols = typer.Typer(
    no_args_is_help=True, help="Symbols of a PLC: write and read .tmc files, compare, type."
)

Origin = Annotated[
    Path, typer.Argument(help="A .tmc or .tpy file, or a folder or file of Structured Text.")
]


@client_command(symbols, PLC_PORT)
async def export(
    client: "Target",
    file: Annotated[Path, typer.Argument(help="The .tmc file to write.")],
) -> None:
    """Write the symbols and types of a running PLC as a .tmc file."""
    from achse.st.symbolfiles import write_tmc

    found = await _of_target(client, file.stem)
    _write(file, write_tmc(found))
    print(f"{file}: {len(found.variables)} variables, {len(found.types)} types")


@symbols.command("import")
def import_(
    origin: Origin,
    to: Annotated[
        Path | None,
        typer.Option("--to", help="Write a station.toml that serves them, or a .tmc file."),
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(min=1, max=65535, help="AMS port of the PLC.", show_default="as in the file"),
    ] = None,
    in_json: Json = False,
) -> None:
    """Read symbols from sources or a symbol file: what is in there, and a station with them."""
    from achse.st.symbolfiles import write_tmc

    found = _of_origin(origin)
    number = port or found.port
    if to is not None:
        if to.suffix.lower() == ".tmc":
            _write(to, write_tmc(found))
        elif to.suffix.lower() == ".toml":
            if to.exists():
                fail(f"{to} exists already: add this to it\n{_plc_table(origin, to, number)}")
            _write(to, _plc_table(origin, to, number).encode())
        else:
            raise typer.BadParameter("a file ending in .toml or .tmc", param_hint="--to")
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
) -> None:
    """Write a Python module with types for a PLC's symbols and methods."""
    from achse.cli.selection import selected
    from achse.client.stubs import programs_of, stubs

    types = await client.types()
    chosen = {
        entry.name: types.symbol_type(entry) for entry in selected(await client.symbols(), pattern)
    }
    text = stubs(chosen, str(client.address), await programs_of(client, chosen))
    if output is None:
        print(text, end="")
    else:
        _write(output, text.encode())
        print(f"{output}: {len(chosen)} symbols")


@client_command(symbols, STATION_PORT)
async def reload(
    client: "Target",
    plc: Annotated[
        int | None,
        typer.Option(min=1, max=65535, help="AMS port of the PLC.", show_default="all"),
    ] = None,
) -> None:
    """Online change: a running achse station reads its sources or symbol files again."""
    from achse.devices.station import ONLINE_CHANGE

    answer = await client.read_write_raw(ONLINE_CHANGE, plc or 0, LONGEST_ANSWER, b"")
    told = json.loads(answer)
    if "error" in told:
        fail(told["error"])
    for port, count in told.items():
        if plc in (None, int(port)):
            print(f"{port}: {count} online changes")


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
    import asyncio

    from achse.ams import AdsError
    from achse.client import connect

    async def ask() -> "SymbolFile":
        async with connect(port=port, reconnect=False, watch_symbols=False) as client:
            return await _of_target(client, str(client.address))

    try:
        return asyncio.run(ask())
    except AdsError as refusal:
        fail(str(refusal))


def _of_origin(origin: Path) -> "SymbolFile":
    """What sources or a symbol file declare."""
    from achse.station import ConfigError
    from achse.station.config import PlcConfig
    from achse.station.plcs import PlcSource

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
        fail(str(fault))


def _plc_table(origin: Path, to: Path, port: int) -> str:
    """The `[[plc]]` table for a station.toml beside which `origin` lies."""
    key = "symbols" if origin.suffix.lower() in (".tmc", ".tpy") else "sources"
    try:
        path = origin.resolve().relative_to(to.resolve().parent)
    except ValueError:
        path = origin.resolve()
    text = str(path).replace("\\", "/").replace('"', '\\"')
    return f'[[plc]]\nport = {port}\n{key} = "{text}"\n'


def _write(file: Path, data: bytes) -> None:
    try:
        file.write_bytes(data)
    except OSError as failure:
        fail(f"{file}: {failure.strerror}")
