"""The link to one target: its NetId, a route to it, and whether it answers us.

A target is found over UDP, and registered at on demand: when it takes our connection but answers
nothing, it has no route to us. Then the state of its system service is read at intervals, so that
a link without traffic is known to be alive.
"""

import asyncio
import logging
import os
from collections.abc import Awaitable, Callable
from enum import Enum

from achse.ams import AmsAddress, NetId
from achse.codes.ports import SYSTEM_PORT
from achse.gateway.configuration import TargetConfig
from achse.gateway.registration import RegistrationError
from achse.gateway.requests import OwnRequests
from achse.router import Router
from achse.router.routes import RouteError
from achse.transport.net_id_query import query_net_id
from achse.transport.uplinks.uplink import Uplink

log = logging.getLogger("achse.gateway")

_FIRST_PAUSE, _LONGEST_PAUSE = 0.2, 5.0
"""Seconds between attempts to find or reach a target, doubled each time."""

_REGISTER_AGAIN = 60.0
"""Seconds between two registrations at a target that goes on refusing us."""


class TargetState(Enum):
    """State of the link to a target."""

    SEARCHING = "searching"
    """Its NetId is unknown."""
    UNREACHABLE = "unreachable"
    """It cannot be connected to."""
    REFUSED = "refused"
    """It takes the connection and answers nothing: it has no route to us."""
    READY = "ready"
    """It answers."""


class Target:
    """A target of the gateway, watched by `run`.

    `uplink(net_id)` returns the way along a route, `register(target, password)` makes the target
    accept us.
    """

    def __init__(
        self,
        config: TargetConfig,
        router: Router,
        requests: OwnRequests,
        uplink: Callable[[NetId], Uplink | None],
        register: Callable[[TargetConfig, str], Awaitable[None]],
        *,
        query: Callable[[str, int, float], Awaitable[NetId | None]] = query_net_id,
    ) -> None:
        self.config = config
        self.net_id = config.net_id
        """NetId of the target; None while it is unknown."""
        self.state = TargetState.SEARCHING
        self.advice = ""
        """Advice to the user about this state; empty if none is needed."""
        self.ads_state: int | None = None
        """ADS state of its system service at the last query."""
        self.settled = asyncio.Event()
        """Set once the target was found, reached or refused for the first time."""
        self._router = router
        self._requests = requests
        self._uplink = uplink
        self._register = register
        self._query = query
        self._registered_at = -_REGISTER_AGAIN
        self._pause = 0.0

    @property
    def uplink(self) -> Uplink | None:
        """The way to the target; None while its NetId is unknown."""
        return None if self.net_id is None else self._uplink(self.net_id)

    async def run(self) -> None:
        """Find the target, and watch it until cancelled."""
        while not await self._find():
            await self._wait()
        self._pause = 0.0
        while True:
            await self._look()
            self.settled.set()
            if self.state is TargetState.READY:
                self._pause = 0.0
                if not self.config.keep_alive:
                    return
                await asyncio.sleep(self.config.keep_alive / 1e9)
            else:
                await self._wait()

    async def _wait(self) -> None:
        self.settled.set()
        self._pause = min(self._pause * 2 or _FIRST_PAUSE, _LONGEST_PAUSE)
        await asyncio.sleep(self._pause)

    async def _find(self) -> bool:
        """Find the NetId and add the route. Return True if both are done."""
        config = self.config
        if self.net_id is None:
            host = config.endpoint[0]
            net_id = await self._query(host, config.udp_port, config.timeout / 1e9)
            if net_id is None:
                self._enter(
                    TargetState.SEARCHING,
                    f"no answer at UDP port {config.udp_port}: give its NetId, --to {config.host}="
                    "NETID or net_id in [[target]]",
                )
                return False
            self.net_id = net_id
        try:
            self._router.routes.add(config.route(self.net_id), fixed=True)
        except RouteError as fault:
            self.net_id = config.net_id
            self._enter(TargetState.SEARCHING, str(fault))
            return False
        return True

    async def _look(self) -> None:
        """Read the state of the target's system service, and register there if it refuses us."""
        uplink = self.uplink
        assert self.net_id is not None
        assert uplink is not None
        connections, returned = uplink.connections, _returned(uplink)
        address = AmsAddress.of(self.net_id, SYSTEM_PORT)
        answer = await self._requests.read_state(address, self.config.timeout / 1e9)
        if answer is not None and answer.source[:6] == self.net_id and not answer.error:
            self.ads_state = int.from_bytes(answer.data[4:6], "little")
            self._enter(TargetState.READY)
            return
        alive = uplink.connected and connections == uplink.connections
        if alive and _returned(uplink) != returned:
            return  # it is slow, or has no system service
        was_ready = self.state is TargetState.READY
        if uplink.connected and answer is None and was_ready:
            uplink.drop(f"no answer within {self.config.timeout / 1e9:g} s")
        opened = uplink.connected or uplink.connections > connections
        if uplink.denied or (opened and not was_ready):
            await self._refused()
        else:
            self._enter(TargetState.UNREACHABLE, uplink.trouble)

    async def _refused(self) -> None:
        """Register at the target, or log the steps for the user."""
        config, now = self.config, asyncio.get_running_loop().time()
        password = config.password or os.environ.get("ACHSE_PASSWORD", "")
        net_id = NetId(self._router.net_id)
        host = config.endpoint[0]
        advice = (
            "certificate unknown there: add it, or give user and password in [[target]]"
            if config.tls is not None
            else f"no route to {net_id} there: add one (`achse ads route add --host {host} --net-id"
            f" {net_id}`, or user and password in [[target]]); or another program of this computer"
            " is connected there"
        )
        if config.user and password and now - self._registered_at >= _REGISTER_AGAIN:
            self._registered_at = now
            try:
                await self._register(config, password)
            except RegistrationError as failure:
                advice = str(failure)
            else:
                log.info("target %s: registered as %s", config.title, config.user)
                self._pause = 0.0
                advice = "registered, waiting for an answer"
        self._enter(TargetState.REFUSED, advice)

    def _enter(self, state: TargetState, advice: str = "") -> None:
        if (state, advice) == (self.state, self.advice):
            return
        self.state, self.advice = state, advice
        level = logging.INFO if state is TargetState.READY else logging.WARNING
        text = f": {advice}" if advice else ""
        log.log(level, "target %s is %s%s", self.config.title, state.value, text)


def _returned(uplink: Uplink) -> int:
    """Return how many frames came back over the present connection."""
    forwarding = None if uplink.peer is None else uplink.peer.forwarding
    return 0 if forwarding is None else forwarding.returned
