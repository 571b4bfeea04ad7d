"""`achse channel` runs part programs: start, stop, reset, state, zero shifts, tools."""

import asyncio
import struct
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.axes.axis import NC_PORT
from achse.cli.failure import fail
from achse.cli.output import decimal, print_json, print_table
from achse.cli.target import Json, client_command

if TYPE_CHECKING:
    from achse.client import Client

_PARAMETERS, _STATES, _FUNCTIONS, _CYCLIC = 0x2000, 0x2100, 0x2200, 0x2300
_GROUP_FUNCTIONS, _GROUP_STATES = 0x3200, 0x3100
_RING0_STATES = 0x1100
_CHANNEL_IDS = 0x31
_LONGEST_LIST = 1020
_INTERPRETER = 2
_LINE = 256

channel = typer.Typer(no_args_is_help=True, help="Run part programs on the channels of the NC.")

Number = Annotated[
    int | None,
    typer.Option("--channel", min=1, max=255, help="Id.", show_default="first with interpreter"),
]


async def _unsigned(client: "Client", group: int, offset: int) -> int:
    return int.from_bytes(await client.read_raw(group, offset, 4), "little")


async def _text(client: "Client", group: int, offset: int, length: int = _LINE) -> str:
    data = await client.read_raw(group, offset, length)
    return data.split(b"\0", 1)[0].decode("cp1252", "replace")


async def _ids(client: "Client") -> list[int]:
    data = await client.read_raw(_RING0_STATES, _CHANNEL_IDS, _LONGEST_LIST)
    return list(struct.unpack(f"<{len(data) // 4}I", data))


async def _chosen(client: "Client", wanted: int | None) -> int:
    """Return the channel, or the first with an interpreter."""
    if wanted is not None:
        return wanted
    for id in await _ids(client):
        if await _unsigned(client, _PARAMETERS + id, 0x03) == _INTERPRETER:
            return id
    return fail("the NC has no channel with an interpreter: [[channel]] in station.toml makes one")


async def _state(client: "Client", id: int) -> dict[str, Any]:
    """Read the state of a channel."""
    from achse.motion.channels.states import InterpreterState

    error = int.from_bytes(await client.read_raw(_STATES + id, 0x01, 4), "little", signed=True)
    image = await client.read_raw(_CYCLIC + id, 0x80, 160)
    block, *_ = struct.unpack_from("<I5I", image)
    number, request = struct.unpack_from("<HH", image, 24)
    state = InterpreterState(await _unsigned(client, _STATES + id, 0x03))
    return {
        "channel": id,
        "state": state.name.lower(),
        "program": await _text(client, _STATES + id, 0x07),
        "block": block,
        "line": await _text(client, _CYCLIC + id, 0x2000_0001),
        "m_function": number if request else None,
        "velocity": struct.unpack_from("<d", image, 88)[0],
        "error": error,
        "place": await _place(client, id),
    }


async def _place(client: "Client", id: int) -> dict[str, Any] | None:
    """Return the block at fault, or the one that a search found; None for none.

    None on other controllers too: the row is of achse alone.
    """
    from achse.ams import DeviceError
    from achse.codes.program_place import FAULT, OFFSET, ProgramPlaceRow

    try:
        data = await client.read_raw(_STATES + id, OFFSET, ProgramPlaceRow.size())
    except DeviceError:
        return None
    place = ProgramPlaceRow.decode(data)
    if not place.kind:
        return None
    return {
        "kind": "fault" if place.kind == FAULT else "found",
        "file": place.file,
        "line": place.line,
        "block": place.block,
        "counter": place.counter,
        "position": list(place.position),
    }


def _state_text(state: dict[str, Any]) -> str:
    """Return a state as a line."""
    text = f"channel {state['channel']}: {state['state']}"
    if state["program"]:
        text += f", {state['program']}"
    if state["line"] and state["state"] not in ("ready", "idle"):
        text += f": {state['line']}"
    if state["m_function"] is not None:
        text += f" (M{state['m_function']} waits: achse channel confirm)"
    if state["error"]:
        from achse.codes import NcError

        row = NcError.of(state["error"])
        text += f", error 0x{state['error']:X}" + (f" {row.name}: {row.text}" if row else "")
    return text + _place_text(state["place"])


def _place_text(place: dict[str, Any] | None) -> str:
    """Return a place, to be read behind a state."""
    if place is None:
        return ""
    number = f" (N{place['block']})" if place["block"] else ""
    x, y, z = place["position"]
    motion = "axes stopped at" if place["kind"] == "fault" else "waits for the axes at"
    return f"; {place['file']}:{place['line']}{number}, {motion} X{x:.3f} Y{y:.3f} Z{z:.3f}"


async def _report(client: "Client", id: int, in_json: bool) -> None:
    state = await _state(client, id)
    if in_json:
        print_json(state)
    else:
        print(_state_text(state))


@client_command(channel, NC_PORT)
async def show(
    client: "Client",
    number: Annotated[
        int | None,
        typer.Argument(
            metavar="[CHANNEL]", min=1, max=255, help="Its id.", show_default="list the channels"
        ),
    ] = None,
    offsets: Annotated[bool, typer.Option("--offsets", help="Its zero shifts.")] = False,
    tools: Annotated[
        bool, typer.Option("--tools", help="Its tools D1 … D50 that have values.")
    ] = False,
    in_json: Json = False,
) -> None:
    """List the channels, or show the state of one: program, line, waiting M function, error."""
    if offsets and tools:
        raise typer.BadParameter("--offsets or --tools, not both")
    if number is None and not (offsets or tools):
        await _list(client, in_json)
        return
    id = await _chosen(client, number)
    if offsets:
        await _show_offsets(client, id, in_json)
    elif tools:
        await _show_tools(client, id, in_json)
    else:
        await _report(client, id, in_json)


async def _list(client: "Client", in_json: bool) -> None:
    """Print all channels: type, groups, axes."""
    from achse.motion.groups.states import ChannelType

    channels: list[dict[str, Any]] = []
    for id in await _ids(client):
        axes = await client.read_raw(_STATES + id, 0x100, _LONGEST_LIST)
        channels.append(
            {
                "channel": id,
                "name": await _text(client, _PARAMETERS + id, 0x02, 31),
                "type": ChannelType(await _unsigned(client, _PARAMETERS + id, 0x03)).name.lower(),
                "group": await _unsigned(client, _PARAMETERS + id, 0x21),
                "axes": list(struct.unpack(f"<{len(axes) // 4}I", axes)),
            }
        )
    if in_json:
        print_json(channels)
        return
    rows = [
        (
            *(str(each["channel"]), str(each["name"]), str(each["type"]), str(each["group"])),
            " ".join(map(str, each["axes"])) or "-",
        )
        for each in channels
    ]
    print_table([("channel", "name", "type", "group", "axes"), *rows], right=frozenset((0, 3)))


@client_command(channel, NC_PORT)
async def assign(
    client: "Client",
    axes: Annotated[
        list[str] | None,
        typer.Argument(help="Axes as X, Y, Z, Q1 …; - for none. Nothing: give all back."),
    ] = None,
    number: Number = None,
    in_json: Json = False,
) -> None:
    """Let the 3D group of the channel have these axes."""
    from achse.cli.axes.nc import chosen

    id = await _chosen(client, number)
    group = await _unsigned(client, _PARAMETERS + id, 0x21)
    if not axes:
        await client.write_raw(_GROUP_FUNCTIONS + group, 0x53, b"")
    else:
        ids = []
        for word in axes:
            chosen_axes = [] if word == "-" else await chosen(client, [word])
            ids.append(chosen_axes[0].axis_id if chosen_axes else 0)
        if len(ids) > 8:
            fail(f"{len(ids)} axes, expected 8 at most: X, Y, Z, Q1 to Q5")
        data = struct.pack("<8I", *ids, *(0,) * (8 - len(ids)))
        await client.write_raw(_GROUP_FUNCTIONS + group, 0x52, data)
    now = struct.unpack("<8I", await client.read_raw(_GROUP_STATES + group, 0x552, 32))
    if in_json:
        print_json({"channel": id, "group": group, "axes": now})
    else:
        shown = " ".join(str(each or "-") for each in now)
        print(f"group {group}: X Y Z Q1 Q2 Q3 Q4 Q5 = {shown}")


@client_command(channel, NC_PORT)
async def start(
    client: "Client",
    program: Annotated[
        str | None,
        typer.Argument(
            help="Load this file of the channel's folder first.", show_default="what is loaded"
        ),
    ] = None,
    load_only: Annotated[
        bool, typer.Option("--load-only", help="Load the program without its start.")
    ] = False,
    wait: Annotated[bool, typer.Option("--wait", help="Show progress until it ends.")] = False,
    number: Number = None,
    in_json: Json = False,
) -> None:
    """Load and start a part program; start the loaded one, or the next single block."""
    if load_only and program is None:
        raise typer.BadParameter("expected a PROGRAM to load", param_hint="--load-only")
    id = await _chosen(client, number)
    if program is not None:
        file = program.encode("cp1252", "replace") + b"\0"
        await client.write_raw(_FUNCTIONS + id, 0x04, file)
    if load_only:
        await _report(client, id, in_json)
        return
    await client.write_raw(_FUNCTIONS + id, 0x02, b"")
    if not wait:
        await _report(client, id, in_json)
        return
    now = await _follow(client, id, in_json)
    if in_json:
        print_json(now)
    if now["error"]:
        raise typer.Exit(1)


async def _follow(client: "Client", id: int, quiet: bool) -> dict[str, Any]:
    """Show a program until it ends: on a terminal in one line that changes, with the velocity on
    the path; else a line for each block that is seen, and for what it waits for."""
    from rich.console import Console
    from rich.text import Text

    console = Console(highlight=False, quiet=quiet)
    before = None
    with console.status("") as line:
        while True:
            now = await _state(client, id)
            shown = now["state"], now["line"], now["m_function"]
            over = now["state"] in ("ready", "idle", "aborted")
            waits = now["m_function"] is not None
            if console.is_terminal and not (over or waits):
                line.update(Text(f"{_state_text(now)} · {now['velocity']:.1f} mm/s"))
            elif shown != before:
                console.print(_state_text(now), markup=False, soft_wrap=True)
            before = shown
            if over:
                return now
            await asyncio.sleep(0.05)


async def _call(client: "Client", offset: int, number: int | None, in_json: bool) -> None:
    id = await _chosen(client, number)
    await client.write_raw(_FUNCTIONS + id, offset, b"")
    await _report(client, id, in_json)


@client_command(channel, NC_PORT)
async def stop(client: "Client", number: Number = None, in_json: Json = False) -> None:
    """Bring the axes to a halt; the program is over."""
    await _call(client, 0x11, number, in_json)


@client_command(channel, NC_PORT)
async def reset(client: "Client", number: Number = None, in_json: Json = False) -> None:
    """Reset errors and forget the program."""
    await _call(client, 0x10, number, in_json)


@client_command(channel, NC_PORT)
async def confirm(client: "Client", number: Number = None, in_json: Json = False) -> None:
    """Grant the M function that waits, as a PLC does."""
    id = await _chosen(client, number)
    for granted in (1, 0):
        await client.write_raw(_CYCLIC + id, 0x00, struct.pack("<HHH122x", 0, 0, granted))
        for _ in range(100):
            request = (await client.read_raw(_CYCLIC + id, 0x80, 160))[26]
            if not request:
                break
            await asyncio.sleep(0.01)
    await _report(client, id, in_json)


async def _show_offsets(client: "Client", id: int, in_json: bool) -> None:
    """Print the zero shifts of a channel."""
    from achse.gcode.state.offsets import ZeroShift

    offsets = {}
    for shift in ZeroShift:
        places = (0x1_0000 + 0x100 * axis + shift for axis in (1, 2, 3))
        values = [await client.read_raw(_PARAMETERS + id, place, 8) for place in places]
        offsets[shift.name] = [struct.unpack("<d", value)[0] for value in values]
    if in_json:
        print_json({"channel": id, "offsets": offsets})
        return
    rows = [(name, *(decimal(value) for value in values)) for name, values in offsets.items()]
    print_table([("shift", "X", "Y", "Z"), *rows], right=frozenset((1, 2, 3)))


async def _show_tools(client: "Client", id: int, in_json: bool) -> None:
    """Print the tools D1 … D50 that have values."""
    from achse.gcode.state.tool_table import ToolParameter

    tools = []
    for place in range(1, 51):
        read = client.read_raw
        tool = int.from_bytes(await read(_PARAMETERS + id, 0x2_0000 + 0x100 * place, 2), "little")
        values: dict[str, Any] = {"place": place, "number": tool}
        for parameter in ToolParameter:
            if parameter is not ToolParameter.NUMBER:
                at = 0x4_0000 + 0x100 * place + parameter
                values[parameter.name.lower()] = struct.unpack(
                    "<d", await read(_PARAMETERS + id, at, 8)
                )[0]
        if any(value for name, value in values.items() if name != "place"):
            tools.append(values)
    if in_json:
        print_json({"channel": id, "tools": tools})
        return
    columns = ("number", "type", "length", "radius", "wear_length", "wear_radius")
    rows = [
        (f"D{each['place']}", *(decimal(float(each[name])) for name in columns)) for each in tools
    ]
    print_table([("place", *columns), *rows], right=frozenset(range(1, 7)))
