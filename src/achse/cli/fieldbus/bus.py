"""`achse bus` shows and changes slaves: of the buses of a station, or served ones."""

import struct
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.fieldbus import bus_serve, interface
from achse.cli.fieldbus.objects import entry_of
from achse.cli.fieldbus.served import access_served, show_served
from achse.cli.options import Count, CycleTime, SaveTo, Watch
from achse.cli.output import hex_dump, print_json, print_table
from achse.cli.target import IO_PORT, ROUTER, SERVED_SLAVES, Json, client_command

if TYPE_CHECKING:
    from achse.client import Client
    from achse.client.target import Target

MASTER_PORT = 0xFFFF

bus = typer.Typer(
    no_args_is_help=True, help="EtherCAT buses: slaves, states, objects, EEPROMs, statistics."
)


_DEVICES = 0x5000
_IDS, _NAME, _NET_ID, _BOX_NAME = 1, 1, 5, 6
_MASTER_STATE, _ADDRESSES, _STATES, _FRAMES, _IDENTITY, _ERRORS = 0x3, 0x7, 0x9, 0xC, 0x11, 0x12
_ABNORMAL, _LOSSES, _DEV_STATE = 0x13, 0x14, 0x45
_TRIPS, _WAY, _CLOCKS, _TROUBLE = 0x101, 0x102, 0x103, 0x104
_STATE_OFFSET = 0x100
_SDO, _COMPLETE = 0xF302, 0x100
_LONGEST = 0x1_0000
_STATE_NAMES = {1: "INIT", 2: "PREOP", 3: "BOOT", 4: "SAFEOP", 8: "OP"}
_STATE_NUMBERS = {name: number for number, name in _STATE_NAMES.items()}
_FLAGS = ((0x10, "error"), (0x20, "wrong slave"), (0x40, "start command refused"))
_LINKS = ((0x01, "not present"), (0x04, "link missing"), (0x08, "additional link"))
_DEV_FLAGS = (
    (0x0001, "link error"),
    (0x0004, "second link lost"),
    (0x0008, "ring is open"),
    (0x0100, "slaves in Init"),
    (0x0200, "slaves in PreOp"),
    (0x0400, "slaves in SafeOp"),
    (0x0800, "slaves with errors"),
    (0x1000, "clocks apart"),
)

_COUNTED = ("station", "port_errors", "losses", "states_left", "clock_ns")

Device = Annotated[int, typer.Option("--device", min=1, help="Id of the bus.")]
Station = Annotated[
    int, typer.Argument(min=1, max=0xFFFE, metavar="STATION", help="Station address: 1001, 1002, …")
]
Served = Annotated[
    bool,
    typer.Option(
        "--served", help="Slaves of `achse drive serve` or `achse bus serve`, beside their master."
    ),
]


def _listens(options: dict[str, Any]) -> tuple[str, int]:
    """Return variable and default of the TCP port, of served slaves or of a router."""
    return SERVED_SLAVES if options["served"] else ROUTER


async def _master(client: "Client", device: int) -> "Target":
    """Return the master of a bus."""
    from achse.ams import NetId

    numbers = struct.unpack("<H", (await client.read_raw(_DEVICES, _IDS, 2))[:2])
    net_id = NetId(await client.read_raw(_DEVICES + device, _NET_ID, 6))
    if not numbers[0]:
        fail("this station has no bus")
    return client.at_port(MASTER_PORT, net_id)


def _flags(value: int, names: tuple[tuple[int, str], ...]) -> list[str]:
    return [name for bit, name in names if value & bit]


async def _slaves(client: "Client", device: int) -> list[dict[str, Any]]:
    """Return the slaves of a bus: address, name, state, identity, what is wrong."""
    master = await _master(client, device)
    data = await master.read_raw(_ADDRESSES, 0, _LONGEST)
    stations = struct.unpack(f"<{len(data) // 2}H", data)
    states = await master.read_raw(_STATES, 0, _LONGEST)
    slaves = []
    for number, station in enumerate(stations):
        name = await client.read_write_raw(
            _DEVICES + device, _BOX_NAME, 256, station.to_bytes(2, "little")
        )
        identity = struct.unpack("<4I", await master.read_raw(_IDENTITY, station, 16))
        state, link = states[2 * number], states[2 * number + 1]
        faults = _flags(state, _FLAGS) + _flags(link, _LINKS)
        if faults or _STATE_NAMES.get(state) != "OP":
            faults += await _trouble(master, station)
        slaves.append(
            {
                "station": station,
                "name": name.rstrip(b"\0").decode("cp1252"),
                "state": _STATE_NAMES.get(state & 0x0F, "none"),
                "faults": faults,
                "vendor": identity[0],
                "product": identity[1],
                "revision": identity[2],
                "serial": identity[3],
            }
        )
    return slaves


async def _trouble(master: "Target", station: int) -> list[str]:
    """Return the reason why a slave did not reach its state, as achse's own masters report it;
    empty without one."""
    from achse.ams import AdsError

    try:
        text = await master.read_raw(_TROUBLE, station, _LONGEST)
    except AdsError:
        return []
    return [text.rstrip(b"\0").decode()] if text.rstrip(b"\0") else []


@client_command(bus, IO_PORT, endless=lambda options: bool(options["watch"]), listens=_listens)
async def state(
    client: "Client",
    station: Annotated[
        int | None,
        typer.Argument(metavar="STATION", help="A slave.", show_default="the whole bus"),
    ] = None,
    wanted: Annotated[
        str | None,
        typer.Argument(
            metavar="STATE", help="init, preop, boot, safeop or op.", show_default="show it"
        ),
    ] = None,
    everything: Annotated[
        str | None, typer.Option("--all", metavar="STATE", help="Request a state of all slaves.")
    ] = None,
    identity: Annotated[
        bool, typer.Option("--identity", help="Show names, vendors and products, too.")
    ] = False,
    statistics: Annotated[
        bool,
        typer.Option(
            "--statistics", help="Show frames, round trips, errors of ports, losses of slaves."
        ),
    ] = False,
    reset: Annotated[
        bool, typer.Option("--reset", help="With --statistics: count from 0 after it.")
    ] = False,
    served: Served = False,
    watch: Watch = False,
    cycle_time: CycleTime = 0.1,
    count: Count = None,
    device: Device = 1,
    in_json: Json = False,
) -> None:
    """Show the slaves and their states, or request one: `1001 safeop`, `--all op`.

    With --watch each change of a slave's state is a line.
    """
    if served:
        await show_served(client, watch, cycle_time, count, in_json)
        return
    if statistics:
        await _statistics(client, reset, device, in_json)
        return
    if watch:
        await _watch(client, device, cycle_time, count, in_json)
        return
    master = await _master(client, device)
    if everything is not None:
        await master.write_raw(_MASTER_STATE, _state_number(everything), b"")
    elif wanted is not None and station is not None:
        await master.write_raw(_STATES, station, _state_number(wanted).to_bytes(2, "little"))
    flags = int.from_bytes(await master.read_raw(_DEV_STATE, 0, 2), "little")
    slaves = [each for each in await _slaves(client, device) if station in (None, each["station"])]
    if station is not None and not slaves:
        fail(f"no slave has the address {station}")
    lowest = int.from_bytes(await master.read_raw(_MASTER_STATE, _STATE_OFFSET, 2), "little")
    facts: dict[str, Any] = {
        "bus": _STATE_NAMES.get(lowest, "none"),
        "faults": _flags(flags, _DEV_FLAGS),
        "slaves": slaves,
    }
    if in_json:
        print_json(facts)
        return
    if station is None:
        print(f"bus: {facts['bus']}; {', '.join(facts['faults']) or 'no fault'}")
    if identity:
        _print_identities(slaves)
        return
    for each in slaves:
        print(f"{each['station']}  {each['state']}  {', '.join(each['faults']) or 'no fault'}")


def _print_identities(slaves: list[dict[str, Any]]) -> None:
    """Print slaves with name, state, identity and faults."""
    print_table(
        [
            ("station", "name", "state", "vendor", "product", "revision", "faults"),
            *(
                (
                    *(str(each["station"]), each["name"], each["state"]),
                    *(f"{each[key]:08X}" for key in ("vendor", "product", "revision")),
                    ", ".join(each["faults"]) or "none",
                )
                for each in slaves
            ),
        ]
    )


def _state_number(name: str) -> int:
    if name.upper() not in _STATE_NUMBERS:
        raise typer.BadParameter(f"init, preop, boot, safeop or op, got {name!r}")
    return _STATE_NUMBERS[name.upper()]


def _an_entry(text: str) -> str:
    """Return the text of an entry; report a wrong one before any request."""
    entry_of(text)
    return text


@client_command(bus, IO_PORT, signed=True, listens=_listens)
async def sdo(
    client: "Client",
    station: Annotated[
        int,
        typer.Argument(
            min=1,
            max=0xFFFE,
            metavar="STATION",
            help="Station address: 1001, 1002, …; of served slaves the place along the cable: 1, …",
        ),
    ],
    entry: Annotated[
        str,
        typer.Argument(
            metavar="INDEX[:SUB]", help="6041, 0x1C32:02, Statusword.", callback=_an_entry
        ),
    ],
    value: Annotated[
        str | None, typer.Argument(help="Write this number, 0x… allowed.", show_default="read")
    ] = None,
    size: Annotated[
        int, typer.Option(min=1, max=8, help="Bytes of VALUE, unless the slave is served.")
    ] = 4,
    complete: Annotated[bool, typer.Option(help="The whole object.")] = False,
    served: Served = False,
    device: Device = 1,
    in_json: Json = False,
) -> None:
    """Read an object of a slave, or write it: `achse bus sdo 1001 6060 8 --size 1`."""
    index, subindex = entry_of(entry)
    if served:
        await access_served(client, station, index, subindex or 0, value, in_json)
        return
    master = await _master(client, device)
    slave = client.at_port(station, master.address.net_id)
    offset = index << 16 | complete * _COMPLETE | (subindex or 0)
    if value is not None:
        await slave.write_raw(_SDO, offset, _bytes_of(value, size))
    data = await slave.read_raw(_SDO, offset, _LONGEST)
    if in_json:
        number = int.from_bytes(data, "little") if len(data) <= 8 else None
        place = {"index": f"0x{index:04X}", "subindex": subindex or 0}
        print_json({**place, "bytes": data.hex(), "value": number})
    elif len(data) <= 8:
        unsigned = int.from_bytes(data, "little")
        signed = int.from_bytes(data, "little", signed=True)
        both = f"{unsigned}" if signed == unsigned else f"{unsigned} ({signed})"
        print(f"{index:04X}:{subindex or 0:02X} = 0x{unsigned:0{2 * len(data)}X} {both}")
    else:
        for line in hex_dump(data):
            print(line)


def _bytes_of(text: str, size: int) -> bytes:
    """Return the bytes of a number; a usage error if it is none or too large."""
    try:
        number = int(text, 0)
    except ValueError:
        raise typer.BadParameter(f"expected a number like 8 or 0x08, got {text!r}") from None
    try:
        return number.to_bytes(size, "little", signed=number < 0)
    except OverflowError:
        raise typer.BadParameter(f"{number} does not fit into {size} bytes") from None


@client_command(bus, IO_PORT)
async def file(
    client: "Client",
    station: Station,
    name: Annotated[str, typer.Argument(metavar="NAME", help="As the slave calls it.")],
    output: SaveTo = None,
    write: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write this.", dir_okay=False, exists=True),
    ] = None,
    password: Annotated[int, typer.Option(min=0, max=0xFFFF_FFFF, metavar="N")] = 0,
    device: Device = 1,
    in_json: Json = False,
) -> None:
    """Read a file of a slave, or write it: `achse bus file 1001 firmware.bin -o saved.bin`."""
    if (output is None) == (write is None):
        raise typer.BadParameter("give either --output or --write")
    from achse.cli.fieldbus.bus_file import read_file, write_file

    master = await _master(client, device)
    slave = client.at_port(station, master.address.net_id)
    if write is not None:
        data = write.read_bytes()
        await write_file(slave, name, password, data)
    else:
        data = await read_file(slave, name, password)
    if output is not None:
        try:
            output.write_bytes(data)
        except OSError as trouble:
            fail(f"{output} cannot be written: {trouble.strerror}")
    if in_json:
        print_json({"station": station, "name": name, "bytes": len(data)})
    else:
        print(f"{name}: {len(data)} bytes {'read' if write is None else 'written'}")


async def _statistics(client: "Client", reset: bool, device: int, in_json: bool) -> None:
    """Print frames sent and lost, round trips, errors of ports, slaves lost and states left."""
    master = await _master(client, device)
    _, *frames = struct.unpack("<5I", await master.read_raw(_FRAMES, 0, 20))
    names = ("cyclic", "cyclic_lost", "acyclic", "acyclic_lost")
    facts: dict[str, Any] = dict(zip(names, frames, strict=True))
    for which, name in enumerate(("interface", "trouble", "second_interface", "ring_open")):
        facts[name] = (await master.read_raw(_WAY, which, _LONGEST)).rstrip(b"\0").decode()
    trips = struct.unpack("<6Q", await master.read_raw(_TRIPS, 0, 48))
    keys = ("count", "missing", "last_ns", "mean_ns", "within_99_percent_ns", "largest_ns")
    facts["round_trips"] = dict(zip(keys, trips, strict=True))
    data = await master.read_raw(_ADDRESSES, 0, _LONGEST)
    stations = struct.unpack(f"<{len(data) // 2}H", data)
    columns = [
        struct.unpack(f"<{len(stations)}I", await master.read_raw(group, 0, _LONGEST))
        for group in (_ERRORS, _LOSSES, _ABNORMAL)
    ]
    clocks = await master.read_raw(_CLOCKS, 0, _LONGEST)
    columns.append(struct.unpack(f"<{len(stations)}i", clocks))
    facts["slaves"] = [
        dict(zip(_COUNTED, each, strict=True)) for each in zip(stations, *columns, strict=True)
    ]
    if reset:
        await master.write_raw(_FRAMES, 0, b"")
        await master.write_raw(_ERRORS, 0, b"")
        await master.write_raw(_TRIPS, 0, b"")
    if in_json:
        print_json(facts)
        return
    print_table([(name.replace("_", " "), str(facts[name])) for name in names], frozenset((1,)))
    if facts["interface"]:
        count, missing, *times = trips
        last, mean, most_of, largest = (f"{each / 1000:.0f}" for each in times)
        where = ", ".join(filter(None, (facts["interface"], facts["second_interface"])))
        print(f"{where}: {facts['trouble'] or 'complete'}")
        print(
            f"round trips: {count}, {missing} cycles without; µs: last {last}, mean {mean},"
            f" 99 % {most_of}, most {largest}"
        )
    if facts["ring_open"]:
        print(f"the ring is open {facts['ring_open']}")
    print_table(
        [
            tuple(name.replace("_", " ") for name in _COUNTED),
            *(tuple(map(str, each.values())) for each in facts["slaves"]),
        ],
        frozenset(range(len(_COUNTED))),
    )


async def _watch(
    client: "Client", device: int, cycle_time: float, count: int | None, in_json: bool
) -> None:
    """Print a line for each change of a slave's state."""
    import asyncio

    before: dict[int, tuple[str, str]] = {}
    seen = 0
    while True:
        for each in await _slaves(client, device):
            now = each["state"], ", ".join(each["faults"]) or "no fault"
            if before.get(each["station"]) == now:
                continue
            before[each["station"]] = now
            if in_json:
                print_json(each)
            else:
                print(f"{each['station']}  {each['name']}  {now[0]}  {now[1]}", flush=True)
            seen += 1
            if seen == count:
                return
        await asyncio.sleep(cycle_time)


bus_serve.register(bus)
interface.register(bus)
