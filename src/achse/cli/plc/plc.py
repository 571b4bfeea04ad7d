"""`achse plc` debugs the Structured Text of a running station: breakpoints, steps, variables."""

import asyncio
import json
import sys
from typing import TYPE_CHECKING, Annotated, Any

import typer

from achse.cli.failure import fail
from achse.cli.options import LetEverybodyIn, Plc
from achse.cli.output import print_json, print_table
from achse.cli.plc.export import export
from achse.cli.plc.picture import draw
from achse.cli.target import STATION_PORT, Json, client_command

if TYPE_CHECKING:
    from achse.client import Client
    from achse.dap.link import DebugLink

plc = typer.Typer(
    no_args_is_help=True,
    help="Debug the PLC programs of a running station; export the sources of one.",
)

Call = Annotated[
    int, typer.Option(min=0, help="Whose variables: 0 is the innermost call, 1 its caller …")
]

_PATIENCE = 2.0
"""Seconds in which a step of a running station should come to its next statement."""

_PAUSE = 0.02

_LONGEST_ANSWER = 1 << 16


def _place(text: str) -> tuple[str, int]:
    path, colon, line = text.rpartition(":")
    if not colon or not line.isdigit() or not path:
        raise typer.BadParameter(f"FILE:LINE, got {text!r}", param_hint="PLACE")
    return path, int(line)


async def _request(link: "DebugLink", do: str, /, **fields: Any) -> Any:
    from achse.dap.link import DebugRefused

    try:
        return await link.request(do, **fields)
    except DebugRefused as refusal:
        fail(str(refusal))


def _link(client: "Client", plc: int) -> "DebugLink":
    from achse.dap.link import DebugLink

    return DebugLink(client, plc)


# breakpoints ---------------------------------------------------------------------------------


@client_command(plc, STATION_PORT, "break")
async def breakpoints(
    client: "Client",
    place: Annotated[
        str | None, typer.Argument(metavar="[FILE:LINE]", show_default="list the breakpoints")
    ] = None,
    condition: Annotated[
        str, typer.Option("--if", metavar="EXPRESSION", help="Stop if this holds.")
    ] = "",
    hits: Annotated[int, typer.Option(min=0, help="Stop from this hit on.")] = 0,
    clear: Annotated[
        int | None,
        typer.Option(metavar="NUMBER", min=0, help="Remove this one; 0: all.", show_default=False),
    ] = None,
    plc: Plc = 0,
    in_json: Json = False,
) -> None:
    """Stop before the first statement at a line, or after it; list breakpoints, or clear them.

    A cycle that stops is halted, with all tasks of its PLC; the station, its NC, other PLCs and
    ADS go on.
    """
    link = _link(client, plc)
    if place is not None and clear is not None:
        raise typer.BadParameter("FILE:LINE or --clear, not both")
    if place is not None:
        await _set_breakpoint(link, place, condition, hits, in_json)
        return
    if clear is not None:
        await _request(link, "clear", number=clear)
    answer = await _request(link, "breaks")
    if in_json:
        print_json(answer)
        return
    for each in answer:
        print(_breakpoint(each))


async def _set_breakpoint(
    link: "DebugLink", place: str, condition: str, hits: int, in_json: bool
) -> None:
    path, line = _place(place)
    answer = await _request(link, "break", path=path, line=line, condition=condition, hits=hits)
    if in_json:
        print_json(answer)
    else:
        print(_breakpoint(answer))
    if not answer["found"]:
        raise typer.Exit(1)


def _breakpoint(facts: dict[str, Any]) -> str:
    parts = [f"{facts['number']}  {_shown_place(facts)}"]
    if facts["condition"]:
        parts.append(f"if {facts['condition']}")
    parts.append(f"{facts['hits']} hits" if facts["found"] else facts["message"])
    return "  ".join(parts)


# going on ------------------------------------------------------------------------------------


@client_command(plc, STATION_PORT, "continue")
async def go_on(
    client: "Client",
    end: Annotated[
        bool,
        typer.Option("--end", help="End debugging: no breakpoints, full speed again."),
    ] = False,
    plc: Plc = 0,
    in_json: Json = False,
) -> None:
    """Go on after a breakpoint, or end debugging."""
    link = _link(client, plc)
    if end:
        await _request(link, "end")
        _report(await _request(link, "state"), in_json)
    else:
        _report(await _request(link, "go"), in_json)


@client_command(plc, STATION_PORT)
async def step(
    client: "Client",
    into: Annotated[bool, typer.Option("--in", help="Into a routine that is called.")] = False,
    out: Annotated[bool, typer.Option("--out", help="To the caller.")] = False,
    plc: Plc = 0,
    in_json: Json = False,
) -> None:
    """Run to the next statement; programs that run stop at theirs."""
    if into and out:
        raise typer.BadParameter("--in or --out, not both")
    link = _link(client, plc)
    if (await _request(link, "state"))["state"] == "run":
        state = await _request(link, "pause")
    else:
        state = await _request(link, "step", how="into" if into else "out" if out else "over")
    _report(await _until_halted(link, state), in_json)


async def _until_halted(link: "DebugLink", state: dict[str, Any]) -> dict[str, Any]:
    """Return the state at the next stop, or what it is after a while."""
    waited = 0.0
    while state["state"] == "run" and waited < _PATIENCE:
        await asyncio.sleep(_PAUSE)
        waited += _PAUSE
        state = await _request(link, "state")
    return state


# looking -------------------------------------------------------------------------------------


@client_command(plc, STATION_PORT, signed=True)
async def show(
    client: "Client",
    expressions: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[EXPRESSION]…",
            help="Variables, or expressions of them; of global variables at any time.",
            show_default="the place of the stop",
        ),
    ] = None,
    variables: Annotated[
        bool, typer.Option("--variables", help="Show all variables of the call.")
    ] = False,
    call: Call = 0,
    plc: Plc = 0,
    in_json: Json = False,
) -> None:
    """Show the place where the PLC is stopped, with its calls, or values of expressions."""
    link = _link(client, plc)
    if not expressions and not variables:
        await _where(link, in_json)
        return
    answers = [
        await _request(link, "evaluate", expression=text, call=call) for text in expressions or ()
    ]
    for scope in ("locals", "instance", "unit") if variables else ():
        answers += await _request(link, "variables", scope=scope, call=call)
    if in_json:
        print_json(answers)
    elif answers:
        print_table([(each["name"], each["type"], each["value"]) for each in answers])


async def _where(link: "DebugLink", in_json: bool) -> None:
    """Print the state of the PLC, and its calls."""
    state = await _request(link, "state")
    calls = await _request(link, "calls")
    if in_json:
        print_json({**state, "calls": calls})
        return
    _report(state, in_json)
    for call in calls:
        print(f"  {call['number']}  {call['routine']}  {_shown_place(call)}")


@client_command(plc, STATION_PORT, "set", signed=True)
async def set_value(
    client: "Client",
    target: Annotated[str, typer.Argument(help="A variable.", show_default=False)],
    value: Annotated[str, typer.Argument(help="A literal, or an expression.", show_default=False)],
    call: Call = 0,
    plc: Plc = 0,
    in_json: Json = False,
) -> None:
    """Give a variable a value, that of a call at a breakpoint too."""
    answer = await _request(_link(client, plc), "set", target=target, value=value, call=call)
    if in_json:
        print_json(answer)
    else:
        print(f"{target} = {answer['value']}")


def _report(state: dict[str, Any], in_json: bool) -> None:
    if in_json:
        print_json(state)
        return
    stop = state.get("stop")
    if stop is None:
        fault = f": {state['fault']}" if state.get("fault") else ""
        print(f"{state['plc']}: {state['state']}{fault}")
        return
    text = f": {stop['text']}" if stop["text"] else ""
    print(
        f"{state['plc']}: {stop['reason']} in {stop['routine']}"
        f" ({_shown_place(stop)}), task {stop['task']}{text}"
    )


def _shown_place(facts: dict[str, Any]) -> str:
    """File and line, and in a drawing the place: `MAIN.TcPOU:45, network 3, rung 1`."""
    place = facts.get("place")
    return f"{facts['path']}:{facts['line']}" + (f", {place}" if place else "")


# online change -------------------------------------------------------------------------------


@client_command(plc, STATION_PORT)
async def reload(
    client: "Client",
    plc: Annotated[
        int,
        typer.Option(min=0, max=65535, help="AMS port of the PLC.", show_default="all"),
    ] = 0,
    in_json: Json = False,
) -> None:
    """Read the sources or symbol files of a running achse station again (online change)."""
    from achse.codes.station import ONLINE_CHANGE

    answer = await client.read_write_raw(ONLINE_CHANGE, plc, _LONGEST_ANSWER, b"")
    outcome = json.loads(answer)
    if "error" in outcome:
        fail(outcome["error"])
    chosen = {port: count for port, count in outcome.items() if plc in (0, int(port))}
    if not chosen:
        fail("no PLC to reload: the station has none, or is between STOP and RUN")
    if in_json:
        print_json(chosen)
        return
    for port, count in chosen.items():
        print(f"{port}: {count} online changes")


plc.command()(export)
client_command(plc, STATION_PORT, alone=lambda options: not options["live"])(draw)


# editors -------------------------------------------------------------------------------------


@plc.command()
def debug(
    listen: Annotated[
        str | None,
        typer.Option(
            metavar="[HOST:]PORT",
            help="Wait for editors at this TCP port, one after the other; 0 is a free one.",
            show_default="standard input and output",
        ),
    ] = None,
    let_everybody_in: LetEverybodyIn = False,
) -> None:
    """Serve an editor that debugs Structured Text by the Debug Adapter Protocol, as VS Code.

    The editor says by `launch` which station.toml to run, or by `attach` where a station runs.
    """
    from achse.dap.serve import OpenToAllError, serve_standard_streams, serve_tcp

    try:
        if listen is None:
            asyncio.run(serve_standard_streams())
        else:
            host, _, port = listen.rpartition(":")
            if not port.isdigit() or int(port) > 65535:
                raise typer.BadParameter(f"[HOST:]PORT, got {listen!r}", param_hint="--listen")
            asyncio.run(
                serve_tcp(host or "127.0.0.1", int(port), _ready, let_everybody_in=let_everybody_in)
            )
    except OpenToAllError as refusal:
        fail(str(refusal))
    except (OSError, UnicodeError) as failure:  # the latter for what cannot be a host name
        fail(f"cannot listen on {listen}: {getattr(failure, 'strerror', None) or failure}")
    except KeyboardInterrupt:
        sys.exit(0)


def _ready(host: str, port: int) -> None:
    print(f"achse debug ready tcp={host}:{port}", flush=True)
