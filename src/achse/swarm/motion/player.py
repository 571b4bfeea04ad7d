"""A world of motion alone: its acts on the device of an NC, every cycle under watch.

No station, clients or network are around it, so that a core plans thousands of moves a second.
"""

from pathlib import Path

from achse.ams import DeviceError
from achse.client.nc.services import services
from achse.codes import NcError
from achse.codes.nc.table import named_rows
from achse.devices.nc.device import NcDevice
from achse.station.building.nc import nc_of
from achse.swarm.channel_watch import ChannelWatch
from achse.swarm.clients import encode_ratios, encode_service
from achse.swarm.life import configuration, write_part_programs
from achse.swarm.motion.checks import NAMES
from achse.swarm.motion.kernel import CYCLES, WrongSetPoint
from achse.swarm.motion.watch import axes_under_watch, reason_of
from achse.swarm.outcome import BrokenInvariant, WorldOutcome
from achse.swarm.track import Track
from achse.swarm.worlds.world import Act, World

_CODES = frozenset(map(int, NcError)) | {0x4FFF}
"""Codes of the table, and the one that operators set."""


class MotionPlayer:
    """A world of motion that runs."""

    def __init__(self, world: World, folder: Path, code: str, track: Track | None = None) -> None:
        self.world = world
        self._track = track
        self.outcome = WorldOutcome()
        write_part_programs(world, folder)
        self.nc = nc_of(configuration(world, code), folder)
        self.now_ns = 0
        self._device = NcDevice(self.nc, clock=lambda: self.now_ns)
        channel = world.channel
        self._channel = None if channel is None else ChannelWatch(channel, self.report)
        if self._channel is not None:
            self._channel.bind(self.nc)
        self._axes = axes_under_watch(
            *(self.nc, {part.name: part for part in world.all_axes}, NAMES),
            channel is not None and channel.keep_jerk,
        )
        self._requested = False
        self._by_cycle = track is not None or (
            self.nc.compiled and code == "auto" and not CYCLES.cached
        )
        """True if each cycle is recorded, or if machine code would have to be compiled first."""

    def report(self, invariant: str, what: str) -> None:
        """Note a violation; the world ends with the first one."""
        if self.outcome.violation is None:
            self.outcome.violation = BrokenInvariant(invariant, what)

    def run(self) -> None:
        """Do all acts and cycles, until a violation or the end."""
        world = self.world
        for act in sorted(world.acts, key=lambda act: act.at_ns):
            if act.at_ns > world.length_ns:
                break
            self._advance(act.at_ns)
            if self.outcome.violation is not None:
                return
            self._act(act)
        self._advance(world.length_ns)

    def finish(self) -> WorldOutcome:
        """Return the figures."""
        outcome, count = self.outcome, len(self.nc)
        outcome.digest = self.nc.digest().hex()
        outcome.station_s = self.now_ns / 1e9
        outcome.cycles = self.nc.cycle_count * count
        outcome.moves = self._axes.moves
        outcome.excuses["abrupt_cycle"] += self._axes.abrupt_cycles
        outcome.ended_ns = self.now_ns
        return outcome

    def _advance(self, end_ns: int) -> None:
        """Do the cycles until then."""
        nc = self.nc
        while self.now_ns < end_ns and self.outcome.violation is None:
            if self._by_cycle or (
                self._channel is not None and (nc.groups.busy or nc.channels.running)
            ):
                nc.cycle()
                done, verdict = 1, self._axes.look()
            else:
                done, verdict = self._axes.cycle(-(-(end_ns - self.now_ns) // nc.cycle_ns))
            self.now_ns += done * nc.cycle_ns
            if self._track is not None:
                self._track.take(self.now_ns, nc)
            wrong = WrongSetPoint.of(verdict)
            if wrong is not None:
                self.report(*reason_of(wrong, nc, self._axes, self.now_ns))
            if self._channel is not None:
                self._channel.look(f"{self.now_ns / 1e9:.6f} s", requested=self._requested)
            self._requested = False
        self._look_at_codes()

    def _look_at_codes(self) -> None:
        for axis in self.nc:
            if axis.error_code and axis.error_code not in _CODES:
                what = f"axis {axis.name} at {self.now_ns / 1e9:.6f} s: {axis.error_code:#x}"
                self.report("known-codes", what)

    def _act(self, act: Act) -> None:
        self._requested = True
        self.outcome.requests += 1
        group, *rest = act.values
        try:
            if act.kind == "ratios":
                self._device.write(*encode_ratios(group, *rest))
                return
            if act.kind == "channel":
                number, name, value = rest
                offset = named_rows(group)[name].offset
                self._device.write(group + number, offset, encode_service(group, name, value))
                return
            name, axis, numbers = rest
            service, data = services()[group][name], encode_service(group, name, numbers)
            if service.answer is not None and not service.writable:
                self._device.read_write(*service.place(axis), service.answer.size, data)
            else:
                self._device.write(*service.place(axis), data)
        except DeviceError:
            pass
