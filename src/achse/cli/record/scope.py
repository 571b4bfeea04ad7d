"""`achse scope` records, shows and exports values of a running station, sampled in its cycle."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.options import Duration
from achse.cli.output import on_terminal, print_event, print_json, print_table
from achse.cli.target import Json, client_command

if TYPE_CHECKING:
    from achse.cli.record.scope_picture import ScopePicture
    from achse.client import Client
    from achse.client.scope import RemoteScope
    from achse.scope.data import ScopeData

PLC_PORT = 851

_RING = 10.0
"""Seconds that are kept at the station until they are read."""

ENDINGS = (".csv", ".scope", ".parquet")

scope = typer.Typer(
    no_args_is_help=True, help="Record values in the cycle of a station, show and export them."
)

Number = Annotated[int, typer.Argument(min=1, help="Number of the scope, see `achse scope show`.")]
Output = Annotated[
    Path, typer.Argument(metavar="FILE", help="Where to: .csv, .scope (binary) or .parquet.")
]


@client_command(scope, PLC_PORT, endless=True, signed=True)
async def record(
    client: "Client",
    file: Output,
    channels: Annotated[
        list[str],
        typer.Argument(
            metavar="CHANNEL...",
            help="SYMBOL, PORT:SYMBOL or PORT:GROUP:OFFSET[:TYPE]; @2ms behind it is how often.",
        ),
    ],
    seconds: Duration = None,
    trigger: Annotated[
        list[str] | None,
        typer.Option(
            metavar="'CHANNEL KIND [NUMBERS]'",
            help="Record around this: rising, falling, edge, above, below LEVEL; enters, leaves,"
            " inside, outside LOW HIGH.",
        ),
    ] = None,
    pretrigger: Annotated[
        float, typer.Option(min=0.0, max=0.999, help="Share of the time before the trigger.")
    ] = 0.1,
    every_trigger: Annotated[
        bool, typer.Option("--all", help="All triggers in the same sample, not any.")
    ] = False,
    in_json: Json = False,
) -> None:
    """Record channels into a file: as they come, or around a trigger; Ctrl-C ends it."""
    from achse.client.scope import defined, scope_of

    _check_output(file)
    length = 10.0 if seconds is None else seconds
    with _reported_errors():
        definition = defined(
            channels,
            port=client.address.port,
            length=length if trigger else _RING,
            triggers=trigger or (),
            pretrigger=pretrigger if trigger else 0.0,
            combine="all" if every_trigger else "any",
            name=file.stem,
        )
        async with scope_of(client, definition) as remote:
            print_event("recording", scope=str(remote.number))
            if trigger:
                data, lost = await _around_trigger(remote), 0
            else:
                data, lost = await _as_it_comes(remote, seconds)
        _save(data, file)
    facts = {"file": str(file), "channels": len(data), "samples": _samples(data), "lost": lost}
    if in_json:
        print_json({"event": "done", **facts})
    else:
        print(f"{file}: {len(data)} channels, {facts['samples']} samples")
    if lost:
        fail(f"{lost} samples were gone before they were read", name="SAMPLES_LOST")


async def _around_trigger(remote: "RemoteScope") -> "ScopeData":
    """Wait for the end of a recording; Ctrl-C ends it with what there is."""
    import asyncio

    with contextlib.suppress(asyncio.CancelledError):
        await remote.wait()
    return await remote.data()


async def _as_it_comes(remote: "RemoteScope", seconds: float | None) -> "tuple[ScopeData, int]":
    """Rows until the time is over or Ctrl-C; how many were lost."""
    import asyncio

    from achse.client.scope import block_of
    from achse.scope.data import ScopeData

    facts = await remote.facts()
    parts: dict[int, list[bytes]] = {}
    firsts: dict[int, int] = {}
    lost = 0
    reached = [0] * len(facts["channel_groups"])
    picture = _picture(facts, seconds)
    with contextlib.suppress(asyncio.CancelledError), picture:
        async for rows in remote.follow():
            group = facts["channel_groups"][rows.group]
            firsts.setdefault(rows.group, rows.first)
            if rows.first > firsts[rows.group] and rows.lost:
                lost += rows.lost * len(group["channels"])
            parts.setdefault(rows.group, []).append(rows.rows)
            picture.add(rows)
            reached[rows.group] = (rows.first + rows.size) * group["step_ns"]
            if seconds is not None and min(reached) >= seconds * 1e9:
                break
    facts = await remote.stop()
    blocks = []
    for number, group in enumerate(facts["channel_groups"]):
        whole = b"".join(parts.get(number, ()))
        if seconds is not None:
            count = max(round(seconds * 1e9) // group["step_ns"], 1)
            whole = whole[: 8 * count * len(group["channels"])]
        blocks.append(block_of(group, firsts.get(number, 0), whole))
    return ScopeData(facts["name"], tuple(blocks)), lost


def _picture(facts: dict[str, Any], seconds: float | None) -> "ScopePicture":
    from achse.cli.record.scope_picture import ScopePicture

    return ScopePicture(facts["channel_groups"], seconds, live=on_terminal())


def _in_file(options: dict[str, Any]) -> bool:
    """Return True if the command is about a file, not about a station."""
    source = options["source"]
    return source is not None and not source.isdecimal()


@client_command(scope, PLC_PORT, alone=_in_file)
async def show(
    client: "Client | None",
    source: Annotated[
        str | None,
        typer.Argument(
            metavar="[NUMBER or FILE]",
            help="A scope of the station, or a .scope file.",
            show_default="list the scopes",
        ),
    ] = None,
    to: Annotated[
        Path | None,
        typer.Option(help="Write it as .csv, .scope or .parquet; no picture.", show_default=False),
    ] = None,
    in_json: Json = False,
) -> None:
    """List the scopes of a station, show the recording of one or of a file, or write it."""
    from achse.client.scope import RemoteScope

    if to is not None:
        _check_output(to, "--to")
    if source is None:
        assert client is not None
        await _list(client, in_json)
        return
    with _reported_errors():
        if client is None:
            data = _loaded(Path(source))
        else:
            data = await _recorded(RemoteScope.of(client, int(source)))
        if to is None:
            _show(data, in_json)
        else:
            _save(data, to)
            _report_saved(data, to, in_json)


async def _list(client: "Client", in_json: bool) -> None:
    """Print the scopes of a station: those of its configuration, and those of clients."""
    from achse.client.scope import scopes_of

    listed = await scopes_of(client)
    if in_json:
        print_json(listed)
    else:
        print_table(
            [
                (str(each["number"]), each["state"], f"{each['channels']} channels", each["name"])
                for each in listed
            ],
            right=frozenset({0}),
        )


def _loaded(file: Path) -> "ScopeData":
    """Return the recording in a file."""
    from achse.scope.data import ScopeData

    try:
        return ScopeData.load(file)
    except OSError as failure:
        fail(f"{file}: {failure.strerror}", name="CANNOT_READ")


async def _recorded(remote: "RemoteScope") -> "ScopeData":
    """Return the recorded data of a scope; without any samples the command ends."""
    with _numbered(remote.number):
        data = await remote.data()
    if not _samples(data):
        fail(f"scope {remote.number} has recorded nothing", name="EMPTY")
    return data


@client_command(scope, PLC_PORT)
async def start(client: "Client", number: Number = 1, in_json: Json = False) -> None:
    """Start a scope of the station; what it had recorded is gone."""
    await _command(client, number, "start", in_json)


@client_command(scope, PLC_PORT)
async def stop(client: "Client", number: Number = 1, in_json: Json = False) -> None:
    """Stop a scope of the station; what it has recorded stays."""
    await _command(client, number, "stop", in_json)


@client_command(scope, PLC_PORT)
async def trigger(client: "Client", number: Number = 1, in_json: Json = False) -> None:
    """Trigger a scope of the station now."""
    await _command(client, number, "trigger", in_json)


async def _command(client: "Client", number: int, word: str, as_json: bool) -> None:
    """Start, stop or trigger a scope, and print its state."""
    from achse.client.scope import RemoteScope

    remote = RemoteScope.of(client, number)
    commands = {"start": remote.start, "stop": remote.stop, "trigger": remote.trigger}
    with _reported_errors(), _numbered(number):
        facts = await commands[word]()
    if as_json:
        print_json({"scope": number, "state": facts["state"]})
    else:
        print(f"scope {number}: {facts['state']}")


@contextlib.contextmanager
def _numbered(number: int) -> Iterator[None]:
    """Report a refusal of the station with the scope's number, and end the command."""
    from achse.ams import DeviceError
    from achse.codes import ReturnCode

    reasons = {
        ReturnCode.NOT_FOUND: f"no scope has the number {number}, see `achse scope show`",
        ReturnCode.INVALID_STATE: f"scope {number} does not wait for a trigger: start it",
        ReturnCode.DEVICE_ACCESS_DENIED: f"scope {number} is another client's",
    }
    try:
        yield
    except DeviceError as refusal:
        for code, reason in reasons.items():
            if refusal.code == code.number:
                fail(reason, name=code.name, code=refusal.code)
        raise


def _show(data: "ScopeData", as_json: bool) -> None:
    from achse.cli.record.scope_picture import lines_of
    from achse.scope.summary import summary

    rows = summary(data)
    if as_json:
        print_json({"name": data.name, "trigger": data.trigger_time, "channels": rows})
        return
    for line in lines_of(data):
        print(line)
    if rows:
        print_table(
            [
                (
                    row["name"], f"{row['samples']} samples", f"{row['sample_time'] * 1000:g} ms",
                    f"{row['min']} … {row['max']}" if row["samples"] else "", row["unit"],
                )
                for row in rows
            ]
        )  # fmt: skip


def _report_saved(data: "ScopeData", file: Path, as_json: bool) -> None:
    if as_json:
        print_json({"file": str(file), "channels": len(data), "samples": _samples(data)})
    else:
        print(f"{file}: {len(data)} channels, {_samples(data)} samples")


def _samples(data: "ScopeData") -> int:
    return sum(map(len, data.tracks))


def _check_output(file: Path, option: str = "FILE") -> None:
    """End before the recording if it could not be written."""
    if file.suffix.lower() not in ENDINGS:
        from achse.iec.nearest import did_you_mean

        near = did_you_mean(file.suffix, ENDINGS) if file.suffix else ""
        raise typer.BadParameter(
            f"expected the ending {', '.join(ENDINGS)}, got {file.name!r}{near}", param_hint=option
        )
    if not file.absolute().parent.is_dir():
        fail(f"{file.parent}: no such folder", name="CANNOT_WRITE")


def _save(data: "ScopeData", file: Path) -> None:
    try:
        data.save(file)
    except OSError as failure:
        fail(f"{file}: {failure.strerror}", name="CANNOT_WRITE")


@contextlib.contextmanager
def _reported_errors() -> Iterator[None]:
    """Report a scope's refusal in a sentence, and end the command."""
    from achse.scope.types import ScopeError

    try:
        yield
    except ScopeError as refusal:
        fail(str(refusal), name="SCOPE")
