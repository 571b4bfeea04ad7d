"""Block search: run a program without its motion up to a block, and begin in the middle of it.

Source: tf5100, block search (ItpBlocksearch); the layouts of its structures are not in the seeds.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum

from achse.gcode.canon import (
    ArcMove,
    BottleneckNotice,
    Canonical,
    DecoderStop,
    DwellTime,
    LineMove,
    Origin,
    PathSetting,
    ProgramEnd,
)
from achse.gcode.vectors import PathPoint


class SearchMode(IntEnum):
    """Meaning of `BlockSearch.wanted`."""

    DISABLED = 0
    BLOCK_NUMBER = 1
    ENTRY_COUNTER = 2


class DryRun(IntEnum):
    """Commands left out on the way to the block; R parameters are always calculated."""

    DISABLED = 0
    SKIP_ALL = 1
    SKIP_MOTION = 2
    SKIP_DWELL_AND_MOTION = 3


@dataclass(frozen=True, slots=True)
class SearchResult:
    """Position of the axes required before the rest of the program begins."""

    origin: Origin
    position: PathPoint
    """X, Y, Z in mm."""
    remaining: float
    """Rest of the block's path, percent."""


@dataclass(slots=True)
class BlockSearch:
    """Block to search for, and the dry run to it; `percent` of its path is passed over, 0..100."""

    mode: SearchMode
    wanted: int
    dry_run: DryRun = DryRun.SKIP_ALL
    percent: float = 0.0
    rest: list[Canonical] = field(default_factory=list)
    """Commands of the found block that are left."""

    def __post_init__(self) -> None:
        if not 0.0 <= self.percent <= 100.0:
            raise ValueError(f"expected 0 to 100 percent, got {self.percent}")

    def keeps(self, command: Canonical) -> bool:
        """Return True if this command is executed on the way."""
        if isinstance(command, PathSetting | BottleneckNotice):
            return True
        if self.dry_run is DryRun.SKIP_ALL:
            return isinstance(command, ProgramEnd)
        if isinstance(command, DwellTime):
            return self.dry_run is not DryRun.SKIP_DWELL_AND_MOTION
        if isinstance(command, LineMove | ArcMove):
            return self.dry_run is DryRun.DISABLED
        return True

    def take(
        self, commands: Sequence[Canonical], origin: Origin, axes: PathPoint
    ) -> SearchResult | None:
        """Look at the commands of a block; not None when it is the one.

        A block whose move was delayed by cutter compensation is found when the move comes out.
        """
        for index, command in enumerate(commands):
            if not self._wanted(command.origin):
                continue
            if isinstance(command, DecoderStop):
                continue
            if not isinstance(command, LineMove | ArcMove):
                if not any(isinstance(each, LineMove | ArcMove) for each in commands[index:]):
                    self.rest = list(commands[index:])
                    return SearchResult(command.origin, self._before(commands, axes), 100.0)
                continue
            left, position = _cut(command, self.percent / 100.0)
            others = [each for each in commands[:index] if self._wanted(each.origin)]
            self.rest = [*others, left, *commands[index + 1 :]]
            return SearchResult(command.origin, position, 100.0 - self.percent)
        if not commands and self._wanted(origin):
            self.rest = []
            return SearchResult(origin, axes, 100.0)
        return None

    def _wanted(self, origin: Origin) -> bool:
        if self.mode is SearchMode.BLOCK_NUMBER:
            return origin.block == self.wanted
        return origin.counter == self.wanted

    @staticmethod
    def _before(commands: Sequence[Canonical], axes: PathPoint) -> PathPoint:
        for command in commands:
            if isinstance(command, LineMove | ArcMove):
                return command.start
        return axes


def _cut(move: LineMove | ArcMove, share: float) -> tuple[LineMove | ArcMove, PathPoint]:
    """Return the rest of a move behind this share of it, and the start of the rest."""
    from dataclasses import replace

    start = move.start if share == 0.0 else move.at(share)
    if isinstance(move, LineMove):
        return replace(move, start=start), start
    left = 1.0 - share
    if left <= 0.0:
        return (
            LineMove(
                move.origin,
                move.end,
                move.end,
                move.auxiliary,
                move.velocity,
                move.velocity,
                exact_stop=move.exact_stop,
            ),
            move.end,
        )
    height = share * move.rise
    centre = tuple(
        each + height * along for each, along in zip(move.centre, move.normal, strict=True)
    )
    return (
        replace(
            move,
            start=start,
            centre=(centre[0], centre[1], centre[2]),
            angle=move.angle * left,
            rise=move.rise * left,
        ),
        start,
    )
