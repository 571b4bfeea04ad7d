"""`achse ads` talks to any ADS device: state, identity, values by name."""

import asyncio
import contextlib
import re
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from achse.cli import complete
from achse.cli.ads import raw
from achse.cli.failure import fail_by
from achse.cli.options import Count, Duration, Watch
from achse.cli.output import print_json, print_table
from achse.cli.target import Json, client_command, ports_hint, ports_that_answer

if TYPE_CHECKING:
    from achse.client import Client
    from achse.client.session.subscription import Sample
    from achse.client.target import Target

PLC_PORT = 851

ads = typer.Typer(no_args_is_help=True, help="Talk to an ADS device: state, values, routes.")
raw.register(ads)

_INDICES = re.compile(r"\[[^]]*\]")
_BETWEEN = re.compile(r",(?![^[]*\])")
"""A comma that is not between brackets."""

Name = Annotated[
    str, typer.Argument(help="A symbol, like MAIN.nCounter.", autocompletion=complete.symbols)
]


def _apart(names: list[str]) -> list[str]:
    """Commas are between indices only; `A,B` are two words."""
    joined = next((name for name in names if "," in _INDICES.sub("", name)), None)
    if joined is not None:
        words = " ".join(word.strip() for word in _BETWEEN.split(joined) if word.strip())
        raise typer.BadParameter(f"names are separate words: {words}; got {joined!r}")
    return names


Names = Annotated[
    list[str],
    typer.Argument(
        help="Symbols, like MAIN.nCounter.", autocompletion=complete.symbols, callback=_apart
    ),
]


@client_command(ads, PLC_PORT)
async def state(
    client: "Client",
    wanted: Annotated[
        str | None,
        typer.Argument(
            metavar="[run|stop|reset|config|…]", help="Request this state.", show_default=False
        ),
    ] = None,
    device_state: Annotated[int, typer.Option(min=0, max=0xFFFF, help="To go with it.")] = 0,
    identity: Annotated[
        bool, typer.Option("--identity", help="Show name, version and address, too.")
    ] = False,
    in_json: Json = False,
) -> None:
    """Show the state of the device, or request another one."""
    if wanted is not None:
        await client.write_control(_state_number(wanted), device_state)
    facts: dict[str, Any] = {}
    if identity:
        device = await client.device_info()
        version = f"{device.major}.{device.minor}.{device.build}"
        facts = {"name": device.name, "version": version, "address": str(client.address)}
    now = await client.state()
    if in_json:
        print_json(facts | _state_json(*now))
    elif identity:
        print_table([*facts.items(), ("state", _state_text(*now))])
    else:
        print(_state_text(*now))


def _state_number(text: str) -> int:
    from achse.ams import AdsState

    try:
        return AdsState[text.upper().replace("-", "_")]
    except KeyError:
        names = ", ".join(item.name.lower().replace("_", "-") for item in AdsState)
        raise typer.BadParameter(f"one of {names}; got {text!r}") from None


def _state_text(ads_state: int, device_state: int) -> str:
    return f"{_state_name(ads_state)} ({int(ads_state)}), device state {device_state}"


def _state_json(ads_state: int, device_state: int) -> dict[str, Any]:
    return {
        "state": _state_name(ads_state),
        "ads_state": int(ads_state),
        "device_state": device_state,
    }


def _state_name(ads_state: int) -> str:
    return getattr(ads_state, "name", "unknown")


def _place(client: "Client", name: str) -> tuple["Target", str]:
    """Return the device and the path of a name that may begin with an AMS port: `500:Axes.X`."""
    port, colon, path = name.partition(":")
    if not colon or not port.isdecimal() or int(port) > 0xFFFF:
        return client, name
    return client.at_port(int(port)), path


@client_command(ads, PLC_PORT, endless=lambda options: bool(options["watch"]))
async def read(
    client: "Client",
    names: Names,
    watch: Watch = False,
    cycle_time: Annotated[
        float, typer.Option("--cycle-time", "-c", min=0, max=429, help="Between samples, s.")
    ] = 0.1,
    cyclic: Annotated[
        bool,
        typer.Option(
            "--cyclic/--on-change", help="With --watch: each sample, or when the value changed."
        ),
    ] = False,
    count: Count = None,
    duration: Duration = None,
    in_json: Json = False,
) -> None:
    """Read variables by name, with --watch until Ctrl-C; `500:Axes.X.ActPos` is at port 500."""
    if watch:
        await _watch(client, names, cycle_time, cyclic, count, duration, in_json)
    else:
        await _read(client, names, in_json)


async def _read(client: "Client", names: list[str], in_json: bool) -> None:
    """Print the values of variables once."""
    from achse.ams import AdsError
    from achse.codes import ReturnCode
    from achse.iec.documents import as_json, as_text

    places = {name: _place(client, name) for name in names}
    values: dict[str, Any] = {}
    for device in dict.fromkeys(target.address for target, _ in places.values()):
        of_device = {name: at for name, at in places.items() if at[0].address == device}
        target = next(iter(of_device.values()))[0]
        outcomes = await target.read_many({path for _, path in of_device.values()}, strict=False)
        values |= {name: outcomes[path] for name, (_, path) in of_device.items()}
    refusals = [value for value in values.values() if isinstance(value, AdsError)]
    shown = {}
    for name, (target, path) in places.items():
        value = values[name]
        if isinstance(value, AdsError):
            continue
        type = await target.type_of(path)
        if in_json:
            shown[name] = as_json(type, value)
        else:
            print(f"{name} = {as_text(type, value)}")
    if in_json:
        print_json(shown)
    if refusals:
        none = ReturnCode.TARGET_PORT_NOT_FOUND.number
        absent = any(getattr(each, "code", 0) == none for each in refusals)
        there = await ports_that_answer(client) if absent else ()
        fail_by(*refusals, hint=ports_hint(client.address.port, there) if there else "")


@client_command(ads, PLC_PORT, signed=True)
async def write(
    client: "Client",
    name: Name,
    value: Annotated[
        str, typer.Argument(help="An IEC literal: 5, 16#FF, TRUE, 'text', T#1s, [1, 2], (a := 1).")
    ],
    in_json: Json = False,
) -> None:
    """Write a variable by name; `500:…` is one of another AMS port."""
    from achse.iec import IecValueError
    from achse.iec.documents import as_json, as_text
    from achse.iec.literals import parse_value

    target, path = _place(client, name)
    type = await target.type_of(path)
    try:
        parsed = parse_value(type, value)
    except IecValueError as fault:
        raise typer.BadParameter(str(fault), param_hint="VALUE") from None
    await target.write(path, parsed)
    if in_json:
        print_json({name: as_json(type, parsed)})
    else:
        print(f"{name} = {as_text(type, parsed)}")


async def _watch(
    client: "Client",
    names: list[str],
    cycle_time: float,
    cyclic: bool,
    count: int | None,
    duration: float | None,
    in_json: bool,
) -> None:
    """Print values as they change, or each sample."""
    places = {name: _place(client, name) for name in names}
    types = {name: await target.type_of(path) for name, (target, path) in places.items()}
    targets = {target.address: target for target, _ in places.values()}
    left = count
    enough = asyncio.Event()

    async def follow(target: "Target") -> None:
        nonlocal left
        shown = {path: name for name, (at, path) in places.items() if at.address == target.address}
        mode: Literal["cycle", "change"] = "cycle" if cyclic else "change"
        async with target.subscribe([*shown], cycle_time=cycle_time, mode=mode) as samples:
            async for sample in samples:
                if enough.is_set():
                    return
                _show(shown[sample.name], types[shown[sample.name]], sample, in_json)
                if left is not None:
                    left -= 1
                    if left == 0:
                        enough.set()
                        return

    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(duration):
            following = [asyncio.create_task(follow(target)) for target in targets.values()]
            ending = asyncio.create_task(enough.wait())
            try:
                await asyncio.wait((*following, ending), return_when=asyncio.FIRST_COMPLETED)
                for task in following:
                    if task.done():
                        task.result()
            finally:
                ending.cancel()
                for task in following:
                    task.cancel()
                await asyncio.gather(*following, ending, return_exceptions=True)


def _show(name: str, type: Any, sample: "Sample", in_json: bool) -> None:
    """Print a sample in its form."""
    from achse.iec.documents import as_json, as_text

    if in_json:
        facts = {"time": sample.time.isoformat(), "name": name}
        value = as_json(type, sample.value)
        print_json({**facts, "value": value, "lost": sample.lost, "gap": sample.gap})
        return
    if sample.lost or sample.gap:
        print("… samples are missing here", flush=True)
    clock = f"{sample.time.astimezone():%H:%M:%S.%f}"[:-3]
    print(f"{clock}  {name} = {as_text(type, sample.value)}", flush=True)
