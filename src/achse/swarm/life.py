"""One life of a station in a world: from the start of its process to its end or a kill."""

import logging
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from achse.ams import AdsState, NetId
from achse.ams.filetime import to_unix_ns
from achse.faults.fault import FaultError, FaultState
from achse.faults.fault_filter import FrameFault
from achse.station import Station
from achse.station.clocks.cycle import CyclicPhase, PhasePlace
from achse.station.configuration.station_file import StationConfig, parse
from achse.station.station import DEFAULT_EPOCH_NS
from achse.swarm.clients import Client
from achse.swarm.disk import MemoryDisk
from achse.swarm.drive_watch import DriveWatch
from achse.swarm.link import NetworkLink, StationScheduler
from achse.swarm.motion.watch import MotionWatch
from achse.swarm.services.cam_watch import CamWatch
from achse.swarm.services.drawing import NET_ID
from achse.swarm.services.scope_watch import ScopeWatch
from achse.swarm.talk import ConnectionLedger
from achse.swarm.track import Track
from achse.swarm.worlds.channels import CHANNEL, GROUP, HANDSHAKE, program_file
from achse.swarm.worlds.machine import drive_axes
from achse.swarm.worlds.program import SAVED, TASK_NS, source_of
from achse.swarm.worlds.world import DrawnChannel, World
from achse.transport.connections.fair_queue import FairQueue
from achse.transport.tcp.listener import TcpListener

_AFTER_NS = 1_000_000_000
"""Time for which a fault that is over still excuses: frames that it delayed."""

_FIRST_PORT = 50_000
"""TCP port of the first client."""

_ON_REQUESTS = frozenset(
    (
        "drop", "delay", "duplicate", "reorder", "truncate", "wrong_invoke_id", "error",
        "router_error",
    )
)  # fmt: skip
"""Faults of frames that hit requests and answers alone, unless for notifications."""

Report = Callable[[str, str], None]


def configuration(world: World, code: str) -> StationConfig:
    """Return the configuration of the station of a world; `code` is as in `[nc]`."""
    document: dict[str, Any] = {
        "router": {"net_id": NET_ID},
        "system": {"persistent_data": "kept.json", "restart_time": "200ms"},
        "nc": {"cycle": f"{world.cycle_ns}ns", "code": code},
        "limits": dict(world.limits),
        "axis": [
            {
                "id": number,
                "name": part.name,
                "unit": part.unit,
                "modulo": part.modulo,
                **part.values,
            }
            for number, part in enumerate(world.all_axes, 1)
        ],
        "table": [
            {"id": number, "kind": "cam", "points": [list(point) for point in points]}
            for number, points in enumerate(world.cams, 1)
        ],
    }
    if world.programs:
        document["plc"] = [
            {
                "port": 851,
                "sources": "plc",
                "code": "plain",
                "task": [{"cycle": f"{TASK_NS}ns", "programs": ["MAIN"]}],
            }
        ]
    if world.channel is not None:
        document |= _channel(world.channel, len(world.axes) + 1)
    return parse({**document, **world.machine}, "world")


def _channel(channel: DrawnChannel, first: int) -> dict[str, Any]:
    """Return the tables of a channel whose axes have the ids from `first` on."""
    return {
        "channel": [
            {"id": CHANNEL, "programs": "nc", "m": [{"number": HANDSHAKE, "handshake": "before"}]}
        ],
        "group": [
            {
                "id": GROUP,
                "channel": CHANNEL,
                "axes": list(range(first, first + len(channel.axes))),
                "keep_jerk": channel.keep_jerk,
                "segments_per_cycle": channel.segments_per_cycle,
                "table_size": channel.table_size,
            }
        ],
    }


def write_part_programs(world: World, folder: Path) -> None:
    """Write the part programs of the channel, if there is one."""
    if world.channel is not None:
        programs = folder / "nc"
        programs.mkdir(exist_ok=True)
        for number, text in enumerate(world.channel.programs):
            (programs / program_file(number)).write_text(text, encoding="utf-8")


class StationLife:
    """A station that lives, with the connections of its clients."""

    def __init__(
        self,
        world: World,
        folder: Path,
        disk: MemoryDisk,
        begun_ns: int,
        code: str,
        checks: Sequence[str],
        report: Report,
        *,
        config: StationConfig | None = None,
    ) -> None:
        """`begun_ns` is the time of the world now. Raises ConfigError."""
        self.world = world
        self.begun_ns = begun_ns
        self.disk = disk
        self._folder = folder
        self._report = report
        self._program = 0
        if world.programs:
            self.write_program()
        write_part_programs(world, folder)
        self.station = Station(
            config or configuration(world, code),
            base=folder,
            epoch_ns=DEFAULT_EPOCH_NS + begun_ns,
            disk=disk,
        )
        self.net_id: NetId = self.station.router.net_id
        self.scheduler = StationScheduler(self.station)
        self.listener = TcpListener(
            self.station.router, fair_queue=FairQueue(self.scheduler.time), max_connections=1 << 16
        )
        self.listener.begin(self.scheduler)
        self.station.admit(self.listener)
        self.watch = MotionWatch(self.station, world.all_axes, checks, report, world.channel)
        self.station.cycle.add(self.watch)
        self.drive_watch: DriveWatch | None = None
        self.service_watches: list[CamWatch | ScopeWatch] = []
        self._add_service_watches(report)
        if "drive" in world.machine:
            self.drive_watch = DriveWatch(self.station, drive_axes(world), report)
            self.station.cycle.add(self.drive_watch)
        self._port = _FIRST_PORT
        self._frames_ns = self._sample_frames_ns = self._samples_ns = -1
        self._disturbed = self._samples_disturbed = False
        self._dropped = 0
        self.pages: list[ConnectionLedger] = []
        self.links: list[NetworkLink] = []

    def _add_service_watches(self, report: Report) -> None:
        for config in self.world.machine.get("camshaft", ()):
            self.service_watches.append(CamWatch(self.station, config, report))
        if self.world.scope:
            epoch_ns = DEFAULT_EPOCH_NS + self.begun_ns
            self.service_watches.append(ScopeWatch(self.station, epoch_ns, report))
        for watch in self.service_watches:
            self.station.cycle.add(watch)

    def record(self, track: Track) -> None:
        """Let the set points of all axes go into a track."""

        def take(now_ns: int) -> None:
            if self.station.nc is not None:
                track.take(self.begun_ns + now_ns, self.station.nc)

        nc = self.station.nc
        if nc is not None:
            self.station.cycle.add(CyclicPhase(PhasePlace.SCOPE, "track", nc.cycle_ns, take))

    # time -----------------------------------------------------------------------------------------

    def now_ns(self) -> int:
        """Time of the world."""
        return self.begun_ns + self.station.time_ns

    def advance_to(self, world_ns: int) -> None:
        """Let time pass until then."""
        self.station.cycle.go_to(
            -(-(world_ns - self.begun_ns) // self.station.tick_ns) * self.station.tick_ns
        )
        self.scheduler.run()
        self._look()

    # connections ----------------------------------------------------------------------------------

    def dial(self, client: Client) -> tuple[NetworkLink, ConnectionLedger] | None:
        """Open a connection to the station."""
        if self.station.ended:
            return None
        self._port += 1
        page = ConnectionLedger(
            f"client {client.number}", self.now_ns, self.world_time, self._report, self
        )  # fmt: skip
        link = NetworkLink(
            self.listener, self.scheduler, client.part, client, self._port, self.watch.wake
        )
        self.pages.append(page)
        self.links.append(link)
        return link, page

    @staticmethod
    def world_time(filetime: int) -> int:
        """Return the time of the world for the stamp of a sample, ns."""
        return to_unix_ns(filetime) - DEFAULT_EPOCH_NS

    # what excuses ---------------------------------------------------------------------------------

    def frames_ns(self) -> int:
        """Time until which frames may be lost, late or changed."""
        self._look()
        return self._frames_ns

    def sample_frames_ns(self) -> int:
        """Time until which frames with samples may be lost, late or changed."""
        self._look()
        return self._sample_frames_ns

    def samples_ns(self) -> int:
        """Time until which subscriptions may miss samples or end."""
        self._look()
        return max(self._samples_ns, self._sample_frames_ns)

    def _look(self) -> None:
        """Note faults that are or were active, changes of the station, and lost samples."""
        station, now = self.station, self.now_ns()
        active = [each.fault for each in station.faults if each.state is FaultState.ACTIVE]
        if active or self._disturbed:
            self._frames_ns = now + _AFTER_NS
        on_samples = any(map(_hits_samples, active))
        if on_samples or self._samples_disturbed:
            self._sample_frames_ns = now + _AFTER_NS
        self._disturbed, self._samples_disturbed = bool(active), on_samples
        devices = [each.notifications for each in station.devices]
        dropped = sum(each.dropped for each in devices) + station.usage.budget.late
        if station.state is not AdsState.RUN or dropped != self._dropped:
            self._samples_ns = now + _AFTER_NS
        self._dropped = dropped

    def excuse_samples(self) -> None:
        """Allow subscriptions to miss samples or end for a moment."""
        self._samples_ns = self.now_ns() + _AFTER_NS

    # acts -----------------------------------------------------------------------------------------

    def act(self, kind: str, values: Sequence[Any]) -> None:
        """Do what an act of the station says."""
        self.watch.wake()
        STATION_ACTS[kind](self, *values)
        self.scheduler.run()

    def fault(self, fields: Mapping[str, Any]) -> None:
        """Begin a fault."""
        try:
            self.station.faults.add(fields["kind"], **_rest(fields))
        except FaultError as refusal:
            logging.getLogger("achse.swarm").debug("no fault: %s", refusal)
        self._frames_ns = self.now_ns() + _AFTER_NS
        if fields["kind"] not in _ON_REQUESTS or fields.get("command") == "notification":
            self._samples_ns = self._sample_frames_ns = self._frames_ns

    def restart(self) -> None:
        """Restart the station."""
        self.excuse_samples()
        self.station.restart()

    def configure(self) -> None:
        """Go to CONFIG; a restart brings it back."""
        self.excuse_samples()
        self.station.configure()

    def online_change(self, number: int) -> None:
        """Load another program, without a stop."""
        self.excuse_samples()
        self._program = number % len(self.world.programs)
        self.write_program()
        if self.station.state is AdsState.RUN:
            self.station.online_change()

    def write_program(self) -> None:
        """Write the source of the present program."""
        folder = self._folder / "plc"
        folder.mkdir(exist_ok=True)
        source = source_of(self.world.programs[self._program])
        (folder / "main.st").write_text(source, encoding="utf-8")

    def inject(self, axis: int, name: str, value: int) -> None:
        """Begin or end a fault of the machine of an axis."""
        nc = self.station.nc
        if nc is not None:
            setattr(nc.axis(axis), name, value)

    def drive_fault(self, fields: Mapping[str, Any]) -> None:
        """Begin a fault of the drives or their cable."""
        for faults in self.station.drive_faults:
            if faults is not None:
                try:
                    faults.add(fields["kind"], **_rest(fields))
                except FaultError as refusal:
                    logging.getLogger("achse.swarm").debug("no fault: %s", refusal)

    def full_disk(self, full: bool) -> None:
        """Leave no room on the disk, or make some."""
        self.disk.full = full

    # the end --------------------------------------------------------------------------------------

    def saved(self) -> int | None:
        """Return the value of the variable that outlives the station; None without a PLC."""
        plc = self.station.plcs.get(851)
        if plc is None:
            return None
        device = next(
            each for each in self.station.devices if any(a.port == 851 for a in each.addresses)
        )
        symbol = None if device.symbols is None else device.symbols.source.resolve(SAVED)
        return None if symbol is None else int.from_bytes(symbol.read(), "little")

    def end(self) -> None:
        """End the process: all connections break off."""
        for link in self.links:
            link.hang_up(orderly=False)
            if not link.ended:
                link._end()
        self.station.cycle.remove(self.watch)
        for watch in (self.drive_watch, *self.service_watches):
            if watch is not None:
                self.station.cycle.remove(watch)


def _hits_samples(fault: object) -> bool:
    """Return False for a fault of frames other than notifications."""
    return not isinstance(fault, FrameFault) or fault.command == "notification"


def _rest(fields: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in fields.items() if name != "kind"}


STATION_ACTS: Mapping[str, Callable[..., None]] = {
    "fault": StationLife.fault,
    "restart": StationLife.restart,
    "configure": StationLife.configure,
    "online_change": StationLife.online_change,
    "inject": StationLife.inject,
    "full_disk": StationLife.full_disk,
    "drive_fault": StationLife.drive_fault,
}
"""Acts of the station by name; `save`, `kill` and `cut` are of the world that runs it."""
