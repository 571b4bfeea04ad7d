"""The G codes and named words of a block, sorted by their modal groups and checked together."""

from dataclasses import dataclass
from functools import lru_cache

from achse.codes import NcError
from achse.gcode.canon import PathPlane
from achse.gcode.errors import WordRefused
from achse.gcode.state.modal import ModalState
from achse.gcode.text.blocks import ProgramBlock
from achse.gcode.text.words import GWord, ModalGroup

_PLANES = {17: PathPlane.XY, 18: PathPlane.ZX, 19: PathPlane.YZ}


@dataclass(frozen=True, slots=True)
class Preparation:
    """Preparation by the words of a block; None where no word sets a value."""

    motion: int | None = None
    in_space: bool = False
    plane: PathPlane | None = None
    cutter: int | None = None
    shift: int | None = None
    programmed_shift: int = 0
    exact_stop: bool = False
    """True for an exact stop in this block only (G09)."""
    all_exact: bool | None = None
    inches: bool | None = None
    feed_inches: bool | None = None
    incremental: bool | None = None
    feed_mode: str = ""
    linear_feed: bool | None = None
    bottleneck: bool | None = None
    correct_centre: bool | None = None
    rotation: str | None = None
    mirror: bool = False
    delete_distance: bool = False
    dwell: bool = False
    homing: bool = False
    dynamics: bool = False

    @property
    def lengths(self) -> bool:
        """True if X, Y, Z are positions of a move, in mm or inches. Angles and seconds are not."""
        return not (self.rotation or self.mirror or self.dwell or self.homing)

    @property
    def positions(self) -> bool:
        """True if the block may make a move. G58 and G59 only set values."""
        return self.lengths and not self.programmed_shift

    def apply(self, modal: ModalState) -> None:
        """Set what stays valid. Plane, rotation and mirror need the block's values too."""
        if self.motion is not None:
            modal.motion = self.motion
        if self.shift is not None:
            modal.shift = self.shift
        if self.all_exact is not None:
            modal.exact_stop = self.all_exact
        if self.inches is not None:
            modal.inches = self.inches
        if self.feed_inches is not None:
            modal.feed_in_inches = self.feed_inches
        if self.incremental is not None:
            modal.incremental = self.incremental
        if self.feed_mode:
            modal.feed_mode = self.feed_mode
        if self.linear_feed is not None:
            modal.linear_feed = self.linear_feed
        if self.bottleneck is not None:
            modal.bottleneck = self.bottleneck
        if self.correct_centre is not None:
            modal.correct_centre = self.correct_centre


_NOTHING = Preparation()


def prepare(block: ProgramBlock) -> Preparation:
    """Return the words of a block. Refused: two of one group, and company for words that are
    alone."""
    words = block.words
    if not words:
        return _NOTHING
    if any(word.alone for word in words):
        _check_alone(block)
    return _sorted(tuple(words))


def _check_alone(block: ProgramBlock) -> None:
    word = next(word for word in block.words if word.alone)
    others = [other.name for other in block.words if other is not word]
    others += [f"M{number}" for number in block.functions]
    allowed = _operands(word)
    others += [name for name in block.values if name not in allowed]
    if block.assignments or block.call is not None:
        others.append("another command")
    if others:
        raise WordRefused(
            NcError.PROGRAM_SYNTAX_RUNNING,
            f"{word.name} needs a block of its own, here is {others[0]} too",
            word.name,
        )


def _operands(word: GWord) -> frozenset[str]:
    if word.group is ModalGroup.DWELL:
        return frozenset("XF")
    if word.group is ModalGroup.SHIFT:
        return frozenset()
    if word.group is ModalGroup.HOMING:
        return frozenset(("X", "Y", "Z", "Q1", "Q2", "Q3", "Q4", "Q5"))
    return frozenset("XYZ")


@lru_cache(maxsize=1024)
def _sorted(words: tuple[GWord, ...]) -> Preparation:
    groups: dict[ModalGroup, GWord] = {}
    for word in words:
        before = groups.setdefault(word.group, word)
        if before is not word:
            raise WordRefused(
                NcError.PROGRAM_SYNTAX_RUNNING,
                f"{before.name} and {word.name} exclude each other ({word.group.value})",
                word.name,
            )
    return Preparation(**_facts(groups))  # type: ignore[arg-type]


def _facts(groups: dict[ModalGroup, GWord]) -> dict[str, object]:
    facts: dict[str, object] = {}
    for group, word in groups.items():
        number = word.number
        if group is ModalGroup.MOTION:
            facts.update({"in_space": True} if number < 0 else {"motion": number})
        elif group is ModalGroup.PLANE:
            facts["plane"] = _PLANES[number]
        elif group is ModalGroup.CUTTER:
            facts["cutter"] = number
        elif group is ModalGroup.SHIFT:
            facts["shift"] = number
        elif group is ModalGroup.PROGRAMMED_SHIFT:
            facts["programmed_shift"] = number
        elif group is ModalGroup.EXACT_STOP:
            facts.update({"exact_stop": True} if number == 9 else {"all_exact": number == 60})
        elif group is ModalGroup.UNIT:
            inches = number in (70, 700)
            facts["inches"] = inches
            facts["feed_inches"] = inches and number == 700
        elif group is ModalGroup.DISTANCE:
            facts["incremental"] = number == 91
        elif group is ModalGroup.FEED_MODE:
            facts["feed_mode"] = word.name
        elif group is ModalGroup.ROTATION:
            facts["rotation"] = word.name
        elif group is not ModalGroup.ANGLE:
            facts.update(_switch(group, word))
    return facts


def _switch(group: ModalGroup, word: GWord) -> dict[str, bool]:
    return {
        ModalGroup.FEED_FORM: {"linear_feed": word.name == "FLIN"},
        ModalGroup.BOTTLENECK: {"bottleneck": word.name == "CDON"},
        ModalGroup.CENTRE: {"correct_centre": word.name == "CPCON"},
        ModalGroup.MIRROR: {"mirror": True},
        ModalGroup.DELETE_DISTANCE: {"delete_distance": True},
        ModalGroup.DWELL: {"dwell": True},
        ModalGroup.HOMING: {"homing": True},
        ModalGroup.DYNAMICS: {"dynamics": True},
    }[group]
