"""Placement: where in PLC memory the storages of a typed project are."""

from collections.abc import Iterable
from typing import NamedTuple

from achse.plc.memory import Area, Memory
from achse.plc.program import PlacedVariable
from achse.st.typed.places import ImageBase, StaticBase, UnitBase

_IMAGES = {"I": Area.INPUT, "Q": Area.OUTPUT, "M": Area.FLAG}


class MissingPlaceError(KeyError):
    """A variable of the project has no memory in this PLC."""


class Spot(NamedTuple):
    """Place of a variable; `bit` is set for a variable at a bit address."""

    area: Area
    offset: int
    bit: int | None = None


class Placement:
    """The places of all variables of units and of VAR_STAT variables."""

    def __init__(self, memory: Memory, variables: Iterable[PlacedVariable]) -> None:
        self.memory = memory
        self._by_name = {placed.name.lower(): placed for placed in variables}
        self.statics: dict[str, PlacedVariable] = {}
        """VAR_STAT variables of functions and methods, by name in lower case."""

    def spot(self, base: UnitBase | StaticBase | ImageBase) -> Spot:
        """Return the begin of a base. Raises `MissingPlaceError`."""
        if isinstance(base, ImageBase):
            return Spot(_IMAGES[base.area], 0)
        if isinstance(base, StaticBase):
            name = f"{base.owner}.{base.variable.name}"
            own = self.statics.get(name.lower())
            if own is not None:
                return Spot(own.area, own.offset)
        else:
            name = f"{base.unit}.{base.variable.name}"
        placed = self._by_name.get(name.lower())
        if placed is None:
            raise MissingPlaceError(name)
        return Spot(placed.area, placed.offset, placed.bit)

    def add_static(self, base: StaticBase) -> None:
        """Give a VAR_STAT variable of a function or method its memory, unless it has some."""
        try:
            self.spot(base)
        except MissingPlaceError:
            variable = base.variable
            region = self.memory[Area.DATA]
            offset = region.allocate(variable.type.size, variable.type.alignment)
            region.write(offset, variable.initial_bytes())
            if variable.retain or variable.persistent:
                region.keep(offset, variable.type.size)
            name = f"{base.owner}.{variable.name}"
            placed = PlacedVariable(name, variable, Area.DATA, offset, None)
            self.statics[name.lower()] = placed
