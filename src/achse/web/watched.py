"""The target that pages show: its client, what it offers, and whether it is reached."""

import asyncio
import contextlib
import json
from collections.abc import Awaitable, Callable
from typing import Any

from achse.ams import AdsError, AmsAddress, ConnectionLost, DeviceError, RouterError
from achse.client import Client, Target
from achse.client.scope import scopes_of
from achse.codes.ports import LOGGER_PORT
from achse.codes.station import SERVICE_PORT
from achse.router.rights import ALL_RIGHTS, Right
from achse.web.arguments import Arguments

NC_PORT, PLC_PORT, STATION_PORT, SCOPE_PORT = 500, 851, SERVICE_PORT, 14_000
IO_PORT = 300

STATISTICS = 0xFA03
"""Index group of the figures at `STATION_PORT`; only achse stations have it."""

LONGEST_TEXT = 1 << 20

_LOOK_WITHIN = 1.0
"""Seconds that a device has to say that it is there."""

Tell = Callable[[str, str], None]
"""Called with `lost` or `back`, and a sentence."""


class WatchedTarget:
    """A client with what all pages share. `rights` bound what pages may ask for."""

    def __init__(self, client: Client, *, name: str = "", rights: Right = ALL_RIGHTS) -> None:
        self.client = client
        self.rights = rights
        self._name = name
        self._listeners: list[Tell] = []
        self._has_scopes: bool | None = None
        self._offers: list[tuple[tuple[str, ...], Callable[[], Awaitable[bool]]]] = []
        self._symbol_listeners: list[Callable[[], None]] = []
        client.session.keep(self)

    @property
    def may_change(self) -> bool:
        """True if pages may write."""
        return bool(self.rights & Right.WRITE)

    def device(self, port: int) -> Target:
        """Return the device at an AMS port of the target."""
        return self.client.at_port(port)

    # whether it is reached -------------------------------------------------------------------

    def on_connection(self, tell: Tell) -> None:
        """Tell of losses and returns from now on."""
        self._listeners.append(tell)

    def ignore_connection(self, tell: Tell) -> None:
        """Undo `on_connection`. Unknown is not an error."""
        self._listeners = [each for each in self._listeners if each != tell]

    @property
    def target(self) -> AmsAddress:
        """For the session: whose symbols it tells of."""
        return self.client.address

    def interrupt(self) -> None:
        """Report for the session that the link is lost."""
        self._tell("lost", f"the connection to {self.client.session.dialer.peer} is lost")

    def renew(self) -> None:
        """Report for the session that there is a link again."""
        self._has_scopes = None
        self._tell("back", f"connected to {self.client.session.dialer.peer} again")

    def symbols_changed(self) -> None:
        """Forget for the session the uploaded symbols: they are out of date."""
        for forget in self._symbol_listeners:
            forget()

    def on_symbols(self, forget: Callable[[], None]) -> None:
        """Call `forget` when symbols are others."""
        self._symbol_listeners.append(forget)

    async def leave(self) -> None:
        """Do nothing: there is nothing to release."""

    def end(self, error: ConnectionLost | None) -> None:
        """Report for the session that the connection has ended."""
        self._tell("lost", "the connection has ended" if error is None else str(error))

    def _tell(self, state: str, text: str) -> None:
        for tell in list(self._listeners):
            tell(state, text)

    # what it is ------------------------------------------------------------------------------

    async def statistics(self) -> dict[str, Any]:
        """Return the figures of an achse station. Raises AdsError for other targets."""
        data = await self.device(STATION_PORT).read_raw(STATISTICS, 0, LONGEST_TEXT)
        figures: dict[str, Any] = json.loads(data)
        return figures

    async def is_there(self, port: int) -> bool:
        """Return True if a device answers at a port."""
        try:
            await self.device(port).within(_LOOK_WITHIN).state()
        except AdsError:
            return False
        return True

    async def has_scopes(self) -> bool:
        """Return True if the target is an achse station with scopes; others lack the service."""
        if self._has_scopes is None:
            try:
                await scopes_of(self.client)
            except (DeviceError, RouterError, ValueError):
                self._has_scopes = False
            else:
                self._has_scopes = True
        return self._has_scopes

    async def features(self) -> list[str]:
        """Return the names of the pages and calls that the target offers."""
        ports = (NC_PORT, PLC_PORT, STATION_PORT, SCOPE_PORT, LOGGER_PORT, IO_PORT)
        features = await asyncio.gather(*map(self.is_there, ports))
        there = dict(zip(ports, features, strict=True))
        station = there[STATION_PORT]
        offered = {
            "axes": there[NC_PORT],
            "overview": True,
            "symbols": there[PLC_PORT] or there[NC_PORT],
            "scope": there[SCOPE_PORT] or there[PLC_PORT] or there[NC_PORT],
            "log": there[LOGGER_PORT],
            "faults": station,
            "traffic": station,
            "tables": there[NC_PORT],
            "statistics": station,
        }
        names = [name for name, offer in offered.items() if offer]
        for more, there_is in self._offers:
            if await there_is():
                names += more
        return names

    def offer(self, names: tuple[str, ...], there: Callable[[], Awaitable[bool]]) -> None:
        """Offer further features, which are there if `there` says so."""
        self._offers.append((names, there))

    @property
    def own_addresses(self) -> frozenset[bytes]:
        """Addresses from which this server itself asks."""
        link = self.client.session.link
        return frozenset(() if link is None else (bytes(link.address),))

    async def hello(self, arguments: Arguments) -> dict[str, Any]:
        """Call `hello`: version of achse, name and time of the target, rights of the page."""
        from achse import __version__

        time = speed = None
        name = self._name
        with contextlib.suppress(AdsError):
            figures = await self.statistics()
            time, speed = figures["time"], figures["speed"] or None
        if not name:
            name = str(self.client.address.net_id)
        return {
            "version": __version__,
            "target": str(self.client.address.net_id),
            "name": name,
            "control": self.may_change,
            "features": await self.features(),
            "time": time,
            "speed": speed,
        }
