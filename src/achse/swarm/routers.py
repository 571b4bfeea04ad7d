"""Routers of a world: the code of `achse router` between clients and the station, in virtual time.

A router lives longer than a station that is killed, and its journal longer than the router.
"""

import heapq
from collections.abc import Callable
from io import BytesIO
from typing import Protocol

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.codes.ports import SYSTEM_PORT
from achse.router import Router
from achse.router.forwarding.journal import HandleJournal
from achse.router.routes import Route
from achse.swarm.clients import Client
from achse.swarm.life import StationLife
from achse.swarm.link import LinkScheduler, NetworkLink, TimedCall
from achse.swarm.services.drawing import net_id_of_router
from achse.swarm.talk import ConnectionLedger, Report
from achse.swarm.worlds.world import DrawnRouter
from achse.transport.connections.fair_queue import FairQueue
from achse.transport.connections.peer import Peer
from achse.transport.tcp.listener import TcpListener
from achse.transport.uplinks.uplink import Uplink

_HOST = "127.0.0.1"

_FIRST_PORT = 20_000
"""TCP port of the first client of a router."""

_QUERY_S = 5.0
"""Seconds between queries of the target's state, as `achse router` sends them."""

_AFTER_NS = 1_000_000_000
"""Time by which frames come later for each router on their way."""

_RESTORED_NS = 4_000_000_000
"""Time in which subscriptions are made again after a connection is back."""


def router_net_id(number: int) -> NetId:
    """Return the NetId of a router."""
    return NetId(net_id_of_router(number))


class RouterScheduler:
    """Scheduler of a router in the time of the world; it outlives a station."""

    def __init__(self, life: StationLife) -> None:
        self._life = life
        self._soon: list[TimedCall] = []
        self._calls: list[tuple[int, int, TimedCall]] = []
        self._number = 0
        self._armed_ns: float = float("inf")
        self._stopped = False

    def move_to(self, life: StationLife) -> None:
        """Continue with another station of the world."""
        self._life, self._armed_ns = life, float("inf")
        self._arm()
        if self._soon:
            life.scheduler.call_soon(self.run)

    def stop(self) -> None:
        """Call nothing more: the process has ended."""
        self._stopped = True
        self._soon.clear()
        self._calls.clear()

    def time(self) -> float:
        """Time of the world, s."""
        return self._life.now_ns() / 1e9

    def call_soon(self, callback: Callable[..., object], *arguments: object) -> TimedCall:
        """Call with the next turn."""
        call = TimedCall(callback, arguments)
        if not self._stopped:
            if not self._soon:
                self._life.scheduler.call_soon(self.run)
            self._soon.append(call)
        return call

    def call_at(
        self, when: float, callback: Callable[..., object], *arguments: object
    ) -> TimedCall:
        """Call at a time of the world, s."""
        return self.call_at_ns(round(when * 1e9), callback, *arguments)

    def call_later(
        self, delay: float, callback: Callable[..., object], *arguments: object
    ) -> TimedCall:
        """Call after so many seconds."""
        return self.call_at(self.time() + delay, callback, *arguments)

    def call_at_ns(
        self, due_ns: int, callback: Callable[..., object], *arguments: object
    ) -> TimedCall:
        """Call at a time of the world, ns."""
        call = TimedCall(callback, arguments)
        if not self._stopped:
            self._number += 1
            heapq.heappush(self._calls, (due_ns, self._number, call))
            self._arm()
        return call

    def _arm(self) -> None:
        if self._calls and self._calls[0][0] < self._armed_ns:
            life = self._life
            self._armed_ns = self._calls[0][0]
            life.scheduler.call_at_ns(round(self._armed_ns) - life.begun_ns, self._step, life)

    def _step(self, life: StationLife) -> None:
        """Make the calls that are due."""
        if life is not self._life:
            return
        now = life.now_ns()
        if self._armed_ns > now:  # an earlier call has been armed and made since
            return
        self._armed_ns = float("inf")
        while self._calls and self._calls[0][0] <= now:
            heapq.heappop(self._calls)[2]()
            self.run()
        self._arm()

    def run(self) -> None:
        """Make the calls of this turn, and those that they add."""
        while self._soon:
            calls, self._soon = self._soon, []
            for call in calls:
                call()


class RouterTransport:
    """Transport of a router's peer: the router's end of a link that it dialled."""

    def __init__(
        self, scheduler: LinkScheduler, peer: Peer, report_end: Callable[[], object]
    ) -> None:
        self._scheduler, self._peer, self._report_end = scheduler, peer, report_end
        self.link: NetworkLink
        self.is_closed = False

    def receive(self, data: bytes) -> None:
        """Pass on bytes from the target."""
        if not self.is_closed:
            self._peer.receive(data)

    def lost(self) -> None:
        """End: the target has closed the connection."""
        if not self.is_closed:
            self.is_closed = True
            self._report_end()
            self._peer.ended()

    def write(self, data: bytes, /) -> None:
        """Send bytes to the target."""
        if not self.is_closed:
            self.link.send(data)

    def get_write_buffer_size(self) -> int:
        """Return 0: nothing is buffered."""
        return 0

    def close(self) -> None:
        """Close after the sent bytes."""
        self._hang_up(orderly=True)

    def abort(self) -> None:
        """End at once."""
        self._hang_up(orderly=False)

    def _hang_up(self, *, orderly: bool) -> None:
        if not self.is_closed:
            self.is_closed = True
            self.link.hang_up(orderly=orderly)
            self._report_end()
            self._scheduler.call_soon(self._peer.ended)

    def die(self) -> None:
        """End with the process of the router, without notice."""
        if not self.is_closed:
            self.is_closed = True
            self.link.hang_up(orderly=False)

    def pause_reading(self) -> None:
        """Leave bytes unread on the link."""
        self.link.read(False)

    def resume_reading(self) -> None:
        """Read the bytes on the link."""
        self.link.read(True)


class LinkTarget(Protocol):
    """Target of a link: a process that a router dials."""

    def listening(self) -> tuple[TcpListener, LinkScheduler, Callable[[], None]] | None:
        """Return listener, scheduler and waking function for a link; None while nothing listens."""

    def add_link(self, link: NetworkLink) -> None:
        """Note a link that ends with the process that listens."""


class RouterProcess:
    """One process of a router, from its start to its end or kill."""

    def __init__(self, owner: "WorldRouter", life: StationLife, file: BytesIO) -> None:
        self._owner = owner
        self.scheduler = RouterScheduler(life)
        self.router = Router(router_net_id(owner.number), source_nat=True)
        self.router.journal = self.journal = HandleJournal(file)
        fair_queue = FairQueue(self.scheduler.time)
        self.listener = TcpListener(self.router, fair_queue=fair_queue, max_connections=1 << 16)
        self.listener.begin(self.scheduler)
        net_id, part = life.net_id, owner.part
        route = Route(name="station", net_id=net_id, host=_HOST, resubscribe=part.resubscribe)
        self.uplink = Uplink(self.router, route, self.scheduler, self._dial)
        self.router.add_route(net_id, self.uplink)
        self._address = self.router.register(0, self)
        self._system = AmsAddress.of(net_id, SYSTEM_PORT)
        self._query_id = 0
        self._transport: RouterTransport | None = None
        self.links: list[NetworkLink] = []
        self._query()

    def deliver(self, frame: Frame) -> bool:
        """Take the answer to a query."""
        return True

    def _query(self) -> None:
        """Read the state of the target."""
        self._query_id += 1
        self.router.deliver(
            Frame(self._system, self._address, Command.READ_STATE, 4, 0, self._query_id, b"")
        )
        self.scheduler.call_later(_QUERY_S, self._query)

    def _dial(self, uplink: Uplink) -> None:
        self.scheduler.call_soon(self._connect, uplink)

    def _connect(self, uplink: Uplink) -> None:
        listening = self._owner.beyond.listening()
        if listening is None:
            uplink.failed("nothing listens")
            return
        listener, scheduler, wake = listening
        peer = uplink.make_peer()
        transport = self._transport = RouterTransport(
            self.scheduler, peer, self._owner.link_changed
        )
        transport.link = NetworkLink(
            listener, scheduler, self._owner.part, transport, self._owner.next_port(), wake
        )
        self._owner.beyond.add_link(transport.link)
        self._owner.link_changed()
        peer.begin(transport, _HOST, 48898)

    def cut(self) -> None:
        """Cut the connection to the target."""
        if self._transport is not None and not self._transport.is_closed:
            self._transport.abort()

    def station_ended(self) -> None:
        """End the link to the station, which has ended."""
        if self._transport is not None:
            self._transport.lost()

    def close(self) -> None:
        """End in an orderly way."""
        self.uplink.close()
        for connection in list(self.listener.connections):
            connection.abort()

    def die(self) -> None:
        """End without notice, as a killed process."""
        self.scheduler.stop()
        if self._transport is not None:
            self._transport.die()
        links, self.links = self.links, []
        for link in links:
            link.die()

    def resources(self) -> dict[str, int]:
        """Return the number of resources of each kind that the router keeps for clients."""
        target = self.uplink.peer
        forwarding = None if target is None else target.forwarding
        net_id = self.uplink.route.net_id
        return {
            "connections": sum(1 for _ in self.listener.connections),
            "known clients": self.router.clients
            - (0 if target is None else len(list(target.senders))),
            "resources": 0 if forwarding is None else len(list(forwarding.resources)),
            "handles in the journal": len(self.journal.handles_at(net_id)),
            "client ports": 0x8000 - self.router.free_ports - 1,
        }


class WorldRouter:
    """A router of a world: its processes one after the other, and the disk of its journal.

    For its clients it is what they dial; it excuses what a lost connection or a fault hits.
    """

    def __init__(
        self, number: int, part: DrawnRouter, life: StationLife, beyond: LinkTarget, report: Report
    ) -> None:
        self.number, self.part, self.beyond = number, part, beyond
        self.net_id = life.net_id
        self._life, self._report = life, report
        self._scheduler = RouterScheduler(life)
        self._file = BytesIO()
        self._port = _FIRST_PORT
        self._frames_ns = self._sample_frames_ns = self._samples_ns = -1
        self.process: RouterProcess | None = RouterProcess(self, life, self._file)
        self.pages: list[ConnectionLedger] = []

    def now_ns(self) -> int:
        """Time of the world."""
        return self._life.now_ns()

    def next_port(self) -> int:
        """Return a TCP port for a connection that begins."""
        self._port += 1
        return self._port

    def listening(self) -> tuple[TcpListener, LinkScheduler, Callable[[], None]] | None:
        """Return listener, scheduler and waking function for a link; None while the router is
        down."""
        process = self.process
        return None if process is None else (process.listener, process.scheduler, _nothing)

    def dial(self, client: Client) -> tuple[NetworkLink, ConnectionLedger] | None:
        """Open a connection to this router."""
        process = self.process
        if process is None:
            return None
        page = ConnectionLedger(
            f"client {client.number} of router {self.number}",
            *(self.now_ns, self._life.world_time, self._report, self),
        )
        link = NetworkLink(
            *(process.listener, process.scheduler, client.part, client, self.next_port(), _nothing)
        )
        self.add_link(link)
        self.pages.append(page)
        return link, page

    def add_link(self, link: NetworkLink) -> None:
        """Note a link to this router, which ends with its process."""
        process = self.process
        assert process is not None
        process.links = [each for each in process.links if not each.ended]
        process.links.append(link)

    # what happens to it ---------------------------------------------------------------------------

    def move_to(self, life: StationLife) -> None:
        """Continue with another station of the world."""
        self._look()
        self._life = life
        self._scheduler.move_to(life)
        if self.process is not None:
            self.process.scheduler.move_to(life)

    def station_ended(self) -> None:
        """Note that the station has ended; routers that are connected to it notice."""
        if self.process is not None and isinstance(self.beyond, StationPlace):
            self.process.station_ended()

    def cut(self, away_ns: int) -> None:
        """Break the connection to the target; it may be dialled at once."""
        if self.process is not None:
            self.process.cut()

    def kill(self, away_ns: int) -> None:
        """End the process without a word; another one starts after a while."""
        process, self.process = self.process, None
        if process is None:
            return
        self._file = BytesIO(self._file.getvalue())
        process.die()
        self.link_changed()
        self._scheduler.call_at_ns(self.now_ns() + away_ns, self.start)

    def restart(self, away_ns: int) -> None:
        """End the process in an orderly way, and start it again."""
        if self.process is not None:
            self.process.close()
            self.process.scheduler.run()
            self.kill(away_ns)

    def start(self) -> None:
        """Start the process, if there is none."""
        if self.process is None:
            self.process = RouterProcess(self, self._life, self._file)

    def end(self) -> None:
        """End for good."""
        if self.process is not None:
            self.process.close()
            self.process.scheduler.run()
            self.process.die()
            self.process = None

    def link_changed(self) -> None:
        """Note that its connection to the target has come or gone: subscriptions miss samples."""
        self._samples_ns = max(self._samples_ns, self.now_ns() + _RESTORED_NS)

    # what excuses ---------------------------------------------------------------------------------

    def _look(self) -> None:
        life = self._life
        self._frames_ns = max(self._frames_ns, life.frames_ns() + _AFTER_NS)
        self._sample_frames_ns = max(self._sample_frames_ns, life.sample_frames_ns() + _AFTER_NS)
        self._samples_ns = max(self._samples_ns, life.samples_ns() + _AFTER_NS)
        if isinstance(self.beyond, WorldRouter):
            self._samples_ns = max(self._samples_ns, self.beyond.samples_ns())

    def frames_ns(self) -> int:
        """Return the time until which frames may be lost, late or changed, ns."""
        self._look()
        return self._frames_ns

    def sample_frames_ns(self) -> int:
        """Return the time until which frames with samples may be lost, late or changed, ns."""
        self._look()
        return self._sample_frames_ns

    def samples_ns(self) -> int:
        """Return the time until which subscriptions may miss samples or end, ns."""
        self._look()
        return max(self._samples_ns, self._sample_frames_ns)

    # the end --------------------------------------------------------------------------------------

    def check_released(self, report: Report) -> None:
        """Check that nothing is held for clients, some time after the last one has left."""
        for what, value in {} if self.process is None else self.process.resources().items():
            if value:
                report("released", f"router {self.number}: {what}: {value}, expected 0")
        if self._frames_ns >= 0:
            return  # a fault may have hit a release
        for device in self._life.station.devices:
            if device.symbols is not None:
                handles = device.symbols.handles
                count = handles.count_of(router_net_id(self.number))
                if count:
                    report("released", f"{count} handles of router {self.number} at the station")


class StationPlace:
    """The station of a world, whichever of its processes there is."""

    def __init__(self, life: Callable[[], StationLife]) -> None:
        self._life = life

    def listening(self) -> tuple[TcpListener, LinkScheduler, Callable[[], None]] | None:
        """Return listener, scheduler and waking function for a link; None while the station is
        down."""
        life = self._life()
        return None if life.station.ended else (life.listener, life.scheduler, life.watch.wake)

    def add_link(self, link: NetworkLink) -> None:
        """Do nothing: `WorldRouter.station_ended` ends the links of routers."""


def _nothing() -> None:
    """Wake nothing: a link to a router has no watch."""


ROUTER_ACTS = {
    "router_cut": WorldRouter.cut,
    "router_kill": WorldRouter.kill,
    "router_restart": WorldRouter.restart,
}
"""Acts of routers by name; values: number of the router, time that it is away, ns."""
