"""Play a world: run its acts in virtual time, and say which invariants did not hold.

A world ends with the first violation: what follows it says little. Its digest covers the state of
the station and every byte that a client received.
"""

import contextlib
import hashlib
import logging
import tempfile
import time
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from achse.ams import AdsState
from achse.station import Station
from achse.station.clocks.cycle import CyclicPhase, PhasePlace
from achse.station.configuration.station_file import StationConfig, load
from achse.swarm.clients import Client
from achse.swarm.disk import MemoryDisk, PowerCut
from achse.swarm.life import StationLife
from achse.swarm.motion.checks import NAMES
from achse.swarm.motion.player import MotionPlayer
from achse.swarm.outcome import BrokenInvariant, WorldOutcome
from achse.swarm.project import PROJECT_INVARIANTS, UserCheck
from achse.swarm.resources import (
    SETTLED_S,
    Replaced,
    check_bounds,
    check_flat,
    check_released,
    is_released,
)
from achse.swarm.routers import ROUTER_ACTS, StationPlace, WorldRouter
from achse.swarm.services.rights import may_write, rights_of
from achse.swarm.track import Track
from achse.swarm.worlds.program import symbols_of
from achse.swarm.worlds.world import STATION, Act, World

_FLAT_EVERY = 8
"""Of so many worlds one is tried for memory that is left behind."""

_CONVERSATION = (
    ("handle", (0,)),
    ("handle", (1,)),
    ("use", (0, None)),
    ("subscribe", (0, True, 100_000_000, 0)),
    ("subscribe_axis", (1, True, 100_000_000, 0)),
    ("release", (0,)),
    ("release", (0,)),
    ("vanish", ()),
)
"""Acts of each client in a round; handles are given back, as abandoned ones are kept."""

_LEAVING_NS = 3_000_000_000
"""Time after which most of what clients held is given back."""

_ROUTERS_NS = 20_000_000_000
"""Time after which routers have released what clients held, over connections that were lost too."""

_USER_CHECKS_NS = 10_000_000
"""Cycle of the checks of a user."""

_LOOK_EVERY_NS = 5_000_000_000
"""Time between two looks at what clients hold."""


class _Violated(Exception):
    pass


@dataclass
class _Saved:
    """Values that a station may have after a kill."""

    acknowledged: int = 0
    attempts: list[int] = field(default_factory=list)
    loose: bool = False
    """True after a restart, which saves at a moment of its own."""


class _Player:
    """A world that runs."""

    def __init__(
        self,
        world: World,
        folder: Path,
        code: str,
        user_checks: Sequence[UserCheck],
        track: Track | None,
    ) -> None:
        self.world = world
        self._track = track
        self._user_checks = user_checks
        self._config: StationConfig | None = None
        if world.project:
            file = Path(world.project)
            self._config, folder = load(file), file.parent
        self.outcome = WorldOutcome()
        self._folder = folder
        self._code = code
        self._disk = MemoryDisk()
        self._violation: BrokenInvariant | None = None
        self._digest = hashlib.blake2b(digest_size=16)
        self._saved = _Saved()
        self._replaced = Replaced()
        self._next_look_ns = _LOOK_EVERY_NS
        self.life = self._begin(0)
        self.routers: list[WorldRouter] = []
        place = StationPlace(lambda: self.life)
        for number, drawn in enumerate(world.routers):
            beyond = place if drawn.behind < 0 else self.routers[drawn.behind]
            self.routers.append(WorldRouter(number, drawn, self.life, beyond, self.report))
        names = symbols_of(world.programs)
        self.clients = [
            Client(
                number,
                part,
                self.life if part.router < 0 else self.routers[part.router],
                *(names, rights_of(world, number)),
            )
            for number, part in enumerate(world.clients)
        ]

    def report(self, invariant: str, what: str) -> None:
        """Note a violation; the world ends with the first one."""
        if self._violation is None:
            self._violation = BrokenInvariant(invariant, what)

    def _begin(self, now_ns: int) -> StationLife:
        checks: Sequence[str] = NAMES
        if self.world.project:
            checks = tuple(each for each in NAMES if each in PROJECT_INVARIANTS)
        life = StationLife(
            *(self.world, self._folder, self._disk, now_ns, self._code, checks, self.report),
            config=self._config,
        )
        if self._track is not None:
            life.record(self._track)
        if self._user_checks:
            station = life.station
            station.cycle.add(
                CyclicPhase(
                    *(PhasePlace.SCOPE, "invariants", _USER_CHECKS_NS),
                    lambda now: self._check_for_user(station),
                )
            )
        return life

    def _check_for_user(self, station: Station) -> None:
        """Call the functions of the user; the station is complete while it is in RUN."""
        if station.state is not AdsState.RUN or station.nc is None:
            return
        for name, check in self._user_checks:
            try:
                wrong = check(station)
            except AssertionError as failure:
                wrong = str(failure) or "an assertion failed"
            if wrong:
                self.report(name, f"at {self.life.now_ns() / 1e9:.6f} s: {wrong}")

    def run(self) -> None:
        """Run all acts, then let all clients leave."""
        acts = sorted(
            (each for each in self.world.acts if each.at_ns <= self.world.length_ns),
            key=lambda act: act.at_ns,
        )
        for act in acts:
            self._advance(act.at_ns)
            self._act(act)
            self._raise()
        self._advance(self.world.length_ns)
        self._settle()

    def _raise(self) -> None:
        for plc in self.life.station.plcs.values():
            if plc.failure:
                self.report("no-traceback", f"PLC: {plc.failure}")
        if self._violation is not None:
            raise _Violated

    def _advance(self, end_ns: int) -> None:
        while self._next_look_ns < end_ns:
            self.life.advance_to(self._next_look_ns)
            self._look()
            self._next_look_ns += _LOOK_EVERY_NS
        self.life.advance_to(end_ns)
        self._raise()

    def _look(self) -> None:
        check_bounds(self.life.station, len(self.clients) + 1, self.report)
        self._replaced.look(self.life.station)
        self._raise()

    def _act(self, act: Act) -> None:
        if act.actor != STATION:
            self.clients[act.actor].act(act.kind, act.values)
            return
        match act.kind:
            case "save":
                self._save()
            case "kill":
                self._kill()
            case "cut":
                self._cut(*act.values)
            case "router_cut" | "router_kill" | "router_restart":
                number, away_ns = act.values
                ROUTER_ACTS[act.kind](self.routers[number], away_ns)
            case _:
                self._saved.loose |= act.kind in ("restart", "configure", "fault")
                self.outcome.restarts += act.kind in ("restart", "configure")
                self._replaced.look(self.life.station)
                self.life.act(act.kind, act.values)

    def _save(self) -> None:
        value = self.life.saved()
        if value is None:
            return
        if self.life.station.save():
            self._saved = _Saved(value)
        else:
            self._saved.attempts.append(value)

    def _cut(self, after: int) -> None:
        """Note that the power fails so many bytes after a save has begun."""
        value = self.life.saved()
        self._disk.cut_after = after
        try:
            self._save()
        except PowerCut:
            if value is not None:
                self._saved.attempts.append(value)
        self._kill()

    def _kill(self) -> None:
        """End the process without a word, and start it again."""
        self._disk.cut_after = None
        self._disk.full = False
        now = self.life.now_ns()
        self._count(self.life)
        self.life.end()
        life = self.life = self._begin(now)
        for router in self.routers:
            router.move_to(life)
            router.station_ended()
        for client in self.clients:
            if client.part.router < 0:
                client.move_to(life)
        value, saved = life.saved(), self._saved
        if (
            value is not None
            and not saved.loose
            and value not in (saved.acknowledged, *saved.attempts)
        ):
            self.report(
                "kept",
                f"after a kill at {now / 1e9:.3f} s the value is {value}, acknowledged was"
                f" {saved.acknowledged}, tried {saved.attempts}",
            )
        if value is not None:
            self._saved = _Saved(saved.acknowledged, [*saved.attempts, value])

    def _settle(self) -> None:
        """Clear what goes wrong, let answers come, and let all clients leave."""
        life = self.life
        life.watch.wake()  # frames that a fault held arrive now
        life.station.faults.clear()
        self._disk.full = False
        if life.station.state is not AdsState.RUN:
            life.station.restart()
        for router in self.routers:
            router.start()
        for client in self.clients:
            client.listen(True)
        # A flood goes through a router by windows, one for each way there and back.
        life.advance_to(life.now_ns() + (_ROUTERS_NS if self.routers else 3_000_000_000))
        for client in self.clients:
            client.finish()
        if self.world.clients and not may_write(self.world) and life.watch.moves:
            self.report("rights", f"{life.watch.moves} commands of clients that may not write")
        self._raise()
        self._digest.update(life.station.digest().encode())
        for number, client in enumerate(self.clients):
            if number % 2:
                client.leave()
            else:
                client.vanish()
        life.advance_to(life.now_ns() + _LEAVING_NS)
        self._end_routers()
        if not is_released(life.station):
            life.advance_to(life.now_ns() + round(SETTLED_S * 1e9))
            check_released(life.station, self.report)
        self._replaced.check(life.station, self.report)
        self._raise()
        if self.world.seed % _FLAT_EVERY == 1:
            self._take_bytes()
            self.outcome.answers += sum(page.answers for page in life.pages)
            self.outcome.samples += sum(page.samples for page in life.pages)
            check_flat(self._converse, self.report)
            self._raise()

    def _end_routers(self) -> None:
        """Look at what routers hold for clients that have left, and end them."""
        for router in reversed(self.routers):
            self.life.advance_to(self.life.now_ns() + _ROUTERS_NS)
            router.check_released(self.report)
            self._raise()
            router.end()
        self.life.scheduler.run()
        self.outcome.answers += sum(page.answers for each in self.routers for page in each.pages)
        self.outcome.samples += sum(page.samples for each in self.routers for page in each.pages)
        for router in self.routers:
            for page in router.pages:
                self.outcome.excuses.update(page.excuses)

    def _converse(self) -> None:
        """Let all clients come, ask, subscribe and leave."""
        life = self.life
        for client in self.clients:
            client.dial()
        for kind, values in _CONVERSATION:
            life.advance_to(life.now_ns() + 1_000_000_000)
            for client in self.clients:
                client.act(kind, values)
        life.advance_to(life.now_ns() + _LEAVING_NS)
        for client in self.clients:
            client.digest_parts.clear()
        life.pages.clear()
        life.links.clear()

    def _count(self, life: StationLife) -> None:
        self.outcome.cycles += life.watch.cycles
        self.outcome.moves += life.watch.moves
        self.outcome.station_s += life.station.time_ns / 1e9
        self.outcome.excuses["abrupt_cycle"] += life.watch.abrupt_cycles
        for page in life.pages:
            self.outcome.excuses.update(page.excuses)
        self.outcome.answers += sum(page.answers for page in life.pages)
        self.outcome.samples += sum(page.samples for page in life.pages)

    def _take_bytes(self) -> None:
        """Add what clients received to the digest."""
        for client in self.clients:
            for part in client.digest_parts:
                self._digest.update(part)
            client.digest_parts.clear()

    def finish(self) -> WorldOutcome:
        """Return what the world was like."""
        self._count(self.life)
        self.outcome.ended_ns = self.life.now_ns()
        for client in self.clients:
            self.outcome.requests += client.requests
        self._take_bytes()
        self.outcome.digest = self._digest.hexdigest()
        self.outcome.violation = self._violation
        return self.outcome


class _Tracebacks(logging.Handler):
    """Reports log records that have an exception."""

    def __init__(self, player: _Player | MotionPlayer) -> None:
        super().__init__(logging.WARNING)
        self._player = player

    def emit(self, record: logging.LogRecord) -> None:
        """Report a record with an exception."""
        if record.exc_info and record.exc_info[1] is not None:
            text = "".join(traceback.format_exception(record.exc_info[1], limit=-3))
            self._player.report("no-traceback", f"{record.getMessage()}: {text[-600:]}")


@contextlib.contextmanager
def _watched_log(player: _Player | MotionPlayer) -> Iterator[None]:
    """Watch the log of achse, and keep its lines to itself."""
    log, handler = logging.getLogger("achse"), _Tracebacks(player)
    propagate, level = log.propagate, log.level
    log.addHandler(handler)
    log.propagate = False
    log.setLevel(logging.WARNING)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.propagate, log.level = propagate, level
        log.setLevel(level)


def play(
    world: World,
    *,
    code: str = "auto",
    checks: Sequence[UserCheck] = (),
    track: Track | None = None,
) -> WorldOutcome:
    """Run a world in this process; `code` is as in `[nc]` of a station.toml.

    `checks` are invariants of a user. The set points of all axes go into `track`.
    """
    began = time.process_time()
    with tempfile.TemporaryDirectory(prefix="achse-swarm-") as folder:
        player: _Player | MotionPlayer
        if world.motion_only:
            player = MotionPlayer(world, Path(folder), code, track)
        else:
            player = _Player(world, Path(folder), code, checks, track)
        with _watched_log(player):
            try:
                player.run()
            except _Violated:
                pass
            except Exception as failure:
                text = "".join(traceback.format_exception(failure, limit=-4))
                player.report("no-traceback", f"{failure!r}: {text[-900:]}")
        outcome = player.finish()
    outcome.cpu_s = time.process_time() - began
    return outcome


def play_twice(world: World, codes: Sequence[str] = ("plain", "machine")) -> WorldOutcome:
    """Run a world in both codes: their digests are equal."""
    first, second = (play(world, code=code) for code in codes)
    if first.violation is None and second.violation is None and first.digest != second.digest:
        second.violation = BrokenInvariant(
            "equal-digest", f"{codes[0]}: {first.digest}, {codes[1]}: {second.digest}"
        )
    second.violation = first.violation or second.violation
    second.cpu_s += first.cpu_s
    return second
