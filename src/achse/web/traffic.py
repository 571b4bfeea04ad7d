"""Traffic of an achse station: requests, answers and notifications as they pass, with names."""

import asyncio
import contextlib
from collections.abc import Callable, Mapping, Sequence
from fnmatch import fnmatchcase

from achse.ams import AdsError
from achse.monitor.decode import Decoder, Exchange
from achse.monitor.names import Names
from achse.router.tap import decode_batch
from achse.server import RowFacts
from achse.web.arguments import Arguments
from achse.web.shared_subscriptions import SharedSubscription
from achse.web.watched import PLC_PORT, STATION_PORT, WatchedTarget

_TAPS = 0xFA02
_FETCH_EVERY = 0.1
_FETCH_BYTES = 1 << 20
"""Bytes of captures decoded at once: it must not hold the station up."""

ServiceRows = Callable[[], Mapping[int, Sequence[RowFacts]]]
"""Gives the rows of devices by AMS port."""


def rows_of_demo() -> Mapping[int, Sequence[RowFacts]]:
    """Return the rows of our own devices: the same numbers mean the same on a real target."""
    from achse.monitor.names import rows_of
    from achse.station import Station

    return rows_of(Station.demo().devices)


class TrafficHandlers:
    """Follows what passes a station."""

    def __init__(self, watched: WatchedTarget, rows: ServiceRows = rows_of_demo) -> None:
        self._watched = watched
        self._station = watched.device(STATION_PORT)
        self._rows = rows
        self._names: Names | None = None

    async def watch(self, subscription: SharedSubscription, arguments: Arguments) -> None:
        """Publish topic `traffic`: exchanges of all clients but this server, filtered."""
        accepted = _Filter(arguments)
        if self._names is None:
            self._names = Names(await asyncio.to_thread(self._rows))
        decoder = Decoder(self._names)
        await self._learn(decoder)
        answer = await self._station.read_write_raw(_TAPS, 0, 4, b"")
        tap = int.from_bytes(answer, "little")
        try:
            while True:
                batch = await self._station.read_raw(_TAPS, tap, _FETCH_BYTES)
                lines = [
                    exchange.as_json()
                    for capture in decode_batch(batch)
                    for exchange in decoder.see(capture)
                    if exchange.client not in self._watched.own_addresses and accepted(exchange)
                ]
                if lines:
                    subscription.show_lines(lines)
                await subscription.pause(_FETCH_EVERY)
        finally:
            closing = asyncio.ensure_future(self._close(tap))
            await asyncio.shield(closing)

    async def _close(self, tap: int) -> None:
        with contextlib.suppress(AdsError):  # it may be gone with the connection
            await self._station.write_raw(_TAPS, tap, b"")

    async def _learn(self, decoder: Decoder) -> None:
        """Learn symbols and types of the PLC, so that values have types."""
        plc = self._watched.device(PLC_PORT)
        count = decoder.names.learn(plc.address)
        if count.is_whole:
            return
        try:
            count.learn_types(await plc.types())
            for entry in await plc.symbols():
                count.learn_symbol(entry)
        except AdsError:
            return  # it has no PLC
        count.is_whole = True


class _Filter:
    """Filter for the exchanges that a page shows."""

    def __init__(self, arguments: Arguments) -> None:
        self._errors = arguments.flag("errors")
        self._samples = arguments.flag("samples")
        self._client = arguments.text("client", "*")
        self._name = arguments.text("name", "*").lower().replace("[", "[[]")

    def __call__(self, exchange: Exchange) -> bool:
        return (
            (self._samples or exchange.command != "notification")
            and (not self._errors or bool(exchange.error) or not exchange.answered)
            and any(
                fnmatchcase(text, self._client) for text in (exchange.peer, str(exchange.client))
            )
            and (
                self._name == "*"
                or any(fnmatchcase(item.name.lower(), self._name) for item in exchange.items)
            )
        )
