"""Completion in shells: axes, symbols, kinds of faults and their fields, of the target in question.

A shell waits while these run: devices that do not answer at once are left out, without a message.
"""

import os
from collections.abc import Callable, Coroutine
from typing import Any

_PATIENCE_S = 0.7
"""For connection and answers together."""

_MOST = 200
"""Highest number of suggestions."""


def _answer_in_time(
    context: Any, port: int, request: Callable[[Any], Coroutine[Any, Any, list[str]]]
) -> list[str]:
    """Return the answer of the command line's target, empty if it does not answer."""
    import asyncio

    from achse.ams import NetId
    from achse.ams.host_port import host_and_port
    from achse.client import connect
    from achse.client.links.link import TcpDialer

    options = getattr(context, "params", None) or {}
    host = options.get("host") or os.environ.get("ACHSE_HOST", "127.0.0.1")
    tcp_port = options.get("tcp_port") or os.environ.get("ACHSE_TCP_PORT") or 48898
    net_id = options.get("net_id")

    async def run() -> list[str]:
        async with (
            asyncio.timeout(_PATIENCE_S),
            connect(
                TcpDialer(*host_and_port(host, int(tcp_port))),
                net_id=NetId(net_id) if net_id else None,
                port=options.get("port") or port,
                timeout=_PATIENCE_S,
                reconnect=False,
                watch_symbols=False,
            ) as client,
        ):
            return await request(client)

    try:
        return asyncio.run(run())
    except Exception:  # a shell must not see any of it
        return []


def axes(ctx: Any, incomplete: str) -> list[str]:
    """Return names of axes, and ids where one has no name."""
    from achse.cli.axes.nc import axes_of

    async def request(client: Any) -> list[str]:
        return [axis.name or str(axis.axis_id) for axis in await axes_of(client)]

    return _beginning(incomplete, _answer_in_time(ctx, 501, request))


def symbols(ctx: Any, incomplete: str) -> list[str]:
    """Return names of symbols, part by part: `MA` → `MAIN.` → `MAIN.nCounter`."""

    async def request(client: Any) -> list[str]:
        return [entry.name for entry in await client.symbols()]

    matches = _beginning(incomplete, _answer_in_time(ctx, 851, request))
    depth = incomplete.count(".") + 1
    parts = dict.fromkeys(
        name if name.count(".") < depth else ".".join(name.split(".")[:depth]) + "."
        for name in matches
    )
    return list(parts)[:_MOST]


def fault_kinds(ctx: Any, incomplete: str) -> list[str]:
    """Kinds of faults: those of drives with `--served` or `--bus` before, else of a station."""
    return _beginning(incomplete, _fault_kinds(ctx))


def fault_fields(ctx: Any, incomplete: str) -> list[str]:
    """`KEY=` for the fields of the kind that is there already."""
    kinds = _fault_kinds(ctx)
    kind = (getattr(ctx, "params", None) or {}).get("kind")
    if kind not in list(kinds):
        return []
    return _beginning(incomplete, [f"{name}=" for name in ("at", *kinds.parameters(kind))])


def _fault_kinds(context: Any) -> Any:
    """Return the kinds that the options of the command line select."""
    from achse.faults.drives import DRIVE_FAULTS
    from achse.faults.kinds import STATION_FAULTS

    options = getattr(context, "params", None) or {}
    return DRIVE_FAULTS if options.get("served") or options.get("bus") else STATION_FAULTS


def _beginning(incomplete: str, names: Any) -> list[str]:
    """Return the names that begin so, without case."""
    wanted = incomplete.casefold()
    return [name for name in names if name.casefold().startswith(wanted)]
