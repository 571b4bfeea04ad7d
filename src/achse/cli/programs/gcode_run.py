"""A part program on axes that only exist in numbers: how long it takes, how fast it is where.

The path is planned as in the station, with look-ahead, jerk and the limits of the axes; handshakes
are granted at once, homing takes no time.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from achse.gcode.canon import (
    ArcMove,
    Canonical,
    DwellTime,
    Handshake,
    HomeAxis,
    LineMove,
    MFunction,
    Moving,
    PathSetting,
)
from achse.gcode.geometry.drawing import PathSample
from achse.motion.channels.program_path import ProgramSettings, segment_of
from achse.motion.path import (
    PathDwell,
    PathLimits,
    PathParameters,
    PathPlanner,
    PathSegment,
    PathTableFull,
    rapid_feed,
)

CYCLE_TIME = 0.002
"""s, as the NC's by default."""
MAX_TIME = 24 * 3600.0
"""s of a run; a longer one is given up."""
_AT_LIMIT = 0.98
"""A velocity or acceleration above this share of its limit is at the limit."""


@dataclass
class ProgramTime:
    """Statistics of a run. Times in s, lengths in mm."""

    seconds: float = 0.0
    dwell: float = 0.0
    feed_length: float = 0.0
    rapid_length: float = 0.0
    moves: int = 0
    handshakes: int = 0
    complete: bool = True
    greatest_velocity: float = 0.0
    """mm/s along the path."""
    at_limit: dict[str, float] = field(default_factory=dict)
    """Seconds for which an axis is at its velocity or acceleration limit: `X velocity` …"""
    samples: list[PathSample] = field(default_factory=list)


class _Run:
    def __init__(
        self,
        limits: Sequence[PathLimits],
        start: Sequence[float],
        *,
        keep_jerk: bool,
        record: bool,
    ) -> None:
        self.limits = limits
        self.settings = ProgramSettings(PathParameters(c0=0.0, keep_jerk=keep_jerk))
        path = self.settings.path
        self.planner = PathPlanner(limits, start, cycle_time=CYCLE_TIME, parameters=path)
        self.record = record
        self.time = ProgramTime()
        self.cycles = 0

    def drain(self) -> Iterator[None]:
        """Run until the path is at its end."""
        while not self.planner.finished:
            self.cycle()
            yield

    def cycle(self) -> None:
        planner, time = self.planner, self.time
        planner.advance()
        self.cycles += 1
        time.greatest_velocity = max(time.greatest_velocity, planner.velocity)
        pairs = zip(self.limits, planner.axis_velocity, planner.axis_acceleration, strict=False)
        for number, (limit, velocity, acceleration) in enumerate(pairs):
            name = "XYZ"[number] if number < 3 else f"Q{number - 2}"
            if abs(velocity) >= _AT_LIMIT * limit.velocity:
                self._count(f"{name} velocity")
            if abs(acceleration) >= _AT_LIMIT * limit.acceleration:
                self._count(f"{name} acceleration")
        if self.record:
            x, y, z = planner.position[:3]
            time.samples.append(PathSample((x, y, z), planner.velocity))

    def _count(self, name: str) -> None:
        self.time.at_limit[name] = self.time.at_limit.get(name, 0.0) + CYCLE_TIME

    def append(self, segment: PathSegment) -> None:
        while True:
            try:
                self.planner.append(segment)
                return
            except PathTableFull:
                self.cycle()

    def move(self, move: Moving) -> None:
        time, end = self.time, (*move.end, *move.auxiliary)
        time.moves += 1
        feed = move.velocity
        if move.rapid:
            time.rapid_length += move.length
            most = [limit.velocity for limit in self.limits]
            feed = rapid_feed(self.planner.programmed_position, end, most)
        else:
            time.feed_length += move.length
        self.append(segment_of(move, end, feed))

    def set(self, setting: PathSetting) -> None:
        self.settings = self.settings.changed(setting)
        self.planner.parameters = self.settings.path
        self.planner.limits = [
            self.settings.limits(limit, place) for place, limit in enumerate(self.limits)
        ]


def run_commands(
    commands: Iterable[Canonical],
    limit: PathLimits,
    start: Sequence[float],
    *,
    keep_jerk: bool = False,
    record: bool = False,
) -> ProgramTime:
    """Run the commands on eight axes with the same limits; `record` keeps each cycle's sample.

    `keep_jerk` as in `PathParameters`.
    `start` is where X, Y, Z and Q1..Q5 are. PathError for a move that cannot be planned.
    """
    run = _Run([limit] * 8, start, keep_jerk=keep_jerk, record=record)
    for command in commands:
        if isinstance(command, LineMove | ArcMove):
            run.move(command)
        elif isinstance(command, DwellTime):
            run.time.dwell += command.seconds
            run.append(PathDwell(command.seconds))
        elif isinstance(command, PathSetting):
            run.set(command)
        elif isinstance(command, HomeAxis) or (
            isinstance(command, MFunction) and command.handshake is not Handshake.NONE
        ):
            run.time.handshakes += isinstance(command, MFunction)
            for _ in run.drain():
                pass
        if run.cycles * CYCLE_TIME > MAX_TIME:
            run.time.complete = False
            break
    else:
        for _ in run.drain():
            if run.cycles * CYCLE_TIME > MAX_TIME:
                run.time.complete = False
                break
    run.time.seconds = run.cycles * CYCLE_TIME
    return run.time
