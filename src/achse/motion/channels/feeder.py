"""The feeder: takes canonical commands in order, and gives motion to a 3D group.

Motion goes ahead into the table of segments; what belongs to a place of the path (fast M functions,
H, S, T, messages) waits until the path is there. What holds the path (handshakes, decoder stops,
homing) waits until all motion before it is done.
"""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import TypeAlias

from achse.codes import NcError
from achse.gcode.canon import (
    ArcMove,
    Canonical,
    DecoderStop,
    DwellTime,
    FastMReset,
    Handshake,
    HomeAxis,
    LineMove,
    MFunction,
    Moving,
    Origin,
    PathSetting,
    ProgramEnd,
    ProgramMessage,
    ProgramStop,
    Technology,
    TechnologyWord,
)
from achse.gcode.interpretation.line_run import LineRun
from achse.motion.channels.program_path import ProgramSettings, segment_of
from achse.motion.channels.technology import TechnologyOutputs
from achse.motion.channels.waits import WaitReason
from achse.motion.checks import OK
from achse.motion.groups.path_group import PathGroup
from achse.motion.path import PathDwell, PathError, PathSegment


class FeedOutcome(Enum):
    """Outcome of a command."""

    DONE = "carried out, or on its way"
    FULL = "the table of segments takes no more now"
    WAITS = "it waits for what was before it, or for the PLC"
    REFUSED = "the error is set"


_PathMark: TypeAlias = tuple[int, Callable[[], None]]
"""Number of the segment behind which something happens, and what."""


@dataclass(frozen=True, slots=True)
class _Entry:
    """Segments with numbers in a row, and the blocks that they come from."""

    first: int
    last: int
    origin: Callable[[int], Origin]
    """Of the segment with this number."""
    auxiliary: int
    """H that was programmed last before them."""


class Feeder:
    """One program's way from commands to motion. `granted` is what the PLC says to handshakes."""

    def __init__(self, group: PathGroup, outputs: TechnologyOutputs) -> None:
        self.group = group
        self.outputs = outputs
        self.granted = 0
        self.error = OK
        """NC error of the last `FeedOutcome.REFUSED`."""
        self.waits_for = WaitReason.PATH
        """Reason of the last `FeedOutcome.WAITS`."""
        self.message = ""
        self._marks: deque[_PathMark] = deque()
        self._entries: deque[_Entry] = deque()
        self._origin: Origin | None = None
        self._auxiliary = outputs.auxiliary
        self._deleting = False
        """The move that can be deleted is the last one: nothing goes behind it before its end."""
        self._deleted = False
        self._displaced_axes: set[int] = set()
        """Main axes that are not where the program has them, since a distance was deleted."""
        self._homing = False
        self._base = self._settings = ProgramSettings(group.path_parameters)
        self._budget = 0

    # where the path is

    @property
    def origin(self) -> Origin | None:
        """The block that the path is on, or was last on."""
        self._forget_entries()
        present = self.group.present
        current = None
        for entry in self._entries:
            if entry.first > present:
                break
            current = entry
        if current is not None:
            self._origin = current.origin(min(present, current.last))
        return self._origin

    def _forget_entries(self) -> None:
        """Forget blocks that the path has passed, unless it may come back to them."""
        group, entries = self.group, self._entries
        first = group.oldest if group.way_back.keeps_path else group.present
        while len(entries) > 1 and entries[0].last < first:
            entries.popleft()

    def block_of(self, number: int) -> tuple[int, int]:
        """N word and H of a segment on the path; 0 of one that is not."""
        for entry in self._entries:
            if entry.first <= number <= entry.last:
                return entry.origin(number).block, entry.auxiliary
        return 0, 0

    @property
    def done(self) -> bool:
        """True if everything so far is carried out."""
        return self.group.rests and not self._marks

    @property
    def can_delete(self) -> bool:
        """True if the present move was programmed with DelDTG."""
        return self._deleting and not self.group.rests

    def delete(self) -> int:
        """End the present move where it is, if it may; 0x42D4 if not."""
        if not self.can_delete:
            return NcError.DELETE_DISTANCE_TO_GO
        self._deleted = True
        return self.group.delete_distance_to_go()

    def pass_marks(self) -> None:
        """Do what belongs to places that the path has passed."""
        self._forget_entries()
        while self._marks and (self.group.rests or self.group.present > self._marks[0][0]):
            self._marks.popleft()[1]()

    def begin_cycle(self) -> None:
        """Limit how many segments may go over in this cycle (group parameter 0x514)."""
        self._budget = self.group.max_commands_per_cycle

    # commands

    @property
    def room(self) -> int:
        """Lines that `feed_lines` takes in this cycle; 0 while each move is looked at alone."""
        if self._deleting or self._displaced_axes or self.group.single_block:
            return 0
        return max(0, min(self._budget, self.group.free))

    def feed_lines(self, run: LineRun) -> FeedOutcome:
        """Lines in a row, from the first that is not taken; the same as one by one.

        If one is refused (`error`), those before it are taken and `run.taken` is its number.
        """
        group, most = self.group, self.room
        if most < 1:
            return FeedOutcome.FULL
        before, begin = group.number, run.taken
        code = group.append_lines(run.ends[begin : begin + most], run.auxiliary, run.velocity)
        count = group.number - before
        if count:
            run.taken += count
            self._budget -= count
            shift = begin - before - 1

            def origin(number: int) -> Origin:
                return run.origin(number + shift)

            self._entries.append(_Entry(before + 1, group.number, origin, self._auxiliary))
        if code:
            return self._refuse(code)
        return FeedOutcome.DONE if run.taken == len(run) else FeedOutcome.FULL

    def feed(self, command: Canonical) -> FeedOutcome:
        """One command, in order; the same again in the next cycle unless it is done."""
        if self._deleting:
            if not self.group.rests:
                return self._wait(WaitReason.DELETABLE_MOVE)
            self._deleting = False
            if self._deleted:
                self._displaced_axes = {0, 1, 2}
                self._deleted = False
        if isinstance(command, LineMove | ArcMove):
            return self._move(command)
        if isinstance(command, DwellTime):
            return self._append(PathDwell(command.seconds), command.origin)
        if isinstance(command, MFunction):
            return self._m_function(command)
        if isinstance(command, FastMReset):
            self._mark(lambda: self.outputs.clear_fast(command.numbers))
        elif isinstance(command, TechnologyWord):
            if command.word is Technology.AUXILIARY:
                self._auxiliary = int(command.value)
            self._mark(lambda: self.outputs.show(command.word, command.value))
        elif isinstance(command, ProgramMessage):
            self._mark(lambda: self._report(command.text))
        elif isinstance(command, PathSetting):
            return self._set(command)
        elif isinstance(command, HomeAxis):
            return self._home(command)
        elif isinstance(command, DecoderStop | ProgramStop | ProgramEnd):
            return FeedOutcome.DONE if self.done else self._wait(WaitReason.PATH)
        return FeedOutcome.DONE

    def _mark(self, action: Callable[[], None]) -> None:
        if self.done:
            action()
        else:
            self._marks.append((self.group.number, action))

    def _report(self, text: str) -> None:
        self.message = text

    def _refuse(self, code: int) -> FeedOutcome:
        self.error = code
        return FeedOutcome.REFUSED

    def _wait(self, reason: WaitReason) -> FeedOutcome:
        self.waits_for = reason
        return FeedOutcome.WAITS

    def _append(self, segment: PathSegment, origin: Origin) -> FeedOutcome:
        if self._budget <= 0 or self.group.free < 1:
            return FeedOutcome.FULL
        code = self.group.append(segment)
        if code:
            return self._refuse(code)
        self._budget -= 1
        number = self.group.number
        self._entries.append(_Entry(number, number, lambda _: origin, self._auxiliary))
        return FeedOutcome.DONE

    def _move(self, move: Moving) -> FeedOutcome:
        planner = self.group.planner
        if planner is None:
            return self._refuse(NcError.NCI_GENERATOR_INACTIVE)
        begin = planner.programmed_position
        end = self._end_of(move, begin)
        if end is None:
            return self._refuse(NcError.CIRCLE_NOT_COMPUTABLE)
        if any((*move.end, *move.auxiliary)[len(begin) :]):
            return self._refuse(NcError.NCI_AXIS_TYPE)
        feed = self.group.rapid_feed(begin, end) if move.rapid else move.velocity
        if not feed > 0.0:
            return self._refuse(NcError.NCI_VELOCITY_NOT_POSITIVE)
        fed = self._append(segment_of(move, end, feed), move.origin)
        if fed is FeedOutcome.DONE and move.delete_distance:
            self._deleting = True
        return fed

    def _end_of(self, move: Moving, begin: Sequence[float]) -> tuple[float, ...] | None:
        """Return the end of the move; None for an arc that would begin elsewhere. Axes that a
        deleted distance has left elsewhere stay there until they are programmed.
        """
        end = [*move.end, *move.auxiliary][: len(begin)]
        if self._displaced_axes and isinstance(move, ArcMove):
            return None
        for axis in list(self._displaced_axes):
            if move.end[axis] == move.start[axis]:
                end[axis] = begin[axis]
            else:
                self._displaced_axes.discard(axis)
        return tuple(end)

    def _m_function(self, command: MFunction) -> FeedOutcome:
        def happen() -> None:
            self.outputs.clear_fast(command.clears)
            if command.fast:
                self.outputs.set_fast(command.number)

        if command.handshake is Handshake.NONE:
            self._mark(happen)
            return FeedOutcome.DONE
        if not self.done:
            return self._wait(WaitReason.PATH)
        if not self.outputs.request:
            happen()
        if self.outputs.handshake(command.number, self.granted):
            return FeedOutcome.DONE
        return self._wait(WaitReason.HANDSHAKE)

    def _home(self, command: HomeAxis) -> FeedOutcome:
        if not self._homing:
            if not self.done:
                return self._wait(WaitReason.PATH)
            code = self.group.home(command.axis)
            if code:
                return self._refuse(code)
            self._homing = True
        if self.group.homing:
            return self._wait(WaitReason.HOMING)
        self._homing = False
        axis = self.group.places[command.axis]
        if axis is None or not axis.homed:  # it was stopped on its way
            code = OK if axis is None else axis.error_code
            return self._refuse(code or NcError.GROUP_CONSEQUENTIAL_ERROR)
        return FeedOutcome.DONE

    def _set(self, setting: PathSetting) -> FeedOutcome:
        group = self.group
        try:
            wanted = replace(self._settings, path=group.path_parameters).changed(setting)
        except (PathError, ValueError):
            return self._refuse(NcError.GROUP_PARAMETER)
        self._use(wanted)
        return FeedOutcome.DONE

    def _use(self, settings: ProgramSettings) -> None:
        self._settings, group = settings, self.group
        group.path_parameters = settings.path
        group.velo_jumps = settings.velo_jumps
        group.dynamic_override = settings.dynamic_override

    def finish(self) -> None:
        """Note that the program is over: what it set is as it was before."""
        self._use(self._base)
        self._marks.clear()
        self._entries.clear()
        self.outputs.drop()
