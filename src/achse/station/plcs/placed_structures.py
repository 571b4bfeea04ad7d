"""Structures of a PLC that are `AT %I` or `AT %Q` and are linked to other parts of the station, by
type."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import product
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

from achse.iec import ArrayType, IecType, StructType, resolved
from achse.iec.nearest import did_you_mean
from achse.plc import Area, PlcRuntime
from achse.plc.program import PlacedVariable
from achse.station.configuration.types import ConfigError

_PLACE = re.compile(r"%([IQ])B(\d{1,9})", re.IGNORECASE)
_AREAS = {"i": Area.INPUT, "q": Area.OUTPUT}

_TypeTest = Callable[[StructType[Any]], bool]


class PlacedStructure(NamedTuple):
    """A structure at an address: `MAIN.Axis1.NcToPlc`, of `MAIN.Axis1`."""

    name: str
    owner: str
    """The structure around it that counts as its owner; its own name if there is none."""
    area: Area
    offset: int
    type: StructType[Any]


class NamedPlace(Protocol):
    """Interface of the places that `find_place` searches."""

    @property
    def name(self) -> str: ...

    @property
    def owner(self) -> str: ...

    @property
    def area(self) -> Area: ...

    @property
    def offset(self) -> int: ...


N = TypeVar("N", bound=NamedPlace)


class ClaimedStructures(Generic[N]):
    """The structures of one kind in all PLCs, and the axis or channel to which each belongs."""

    def __init__(self, structures: Mapping[int, Iterable[N]]) -> None:
        self.structures = {
            (port, each.name.casefold()): each
            for port, of_plc in structures.items()
            for each in of_plc
        }
        """Structures by port and name in lower case."""
        self.used_by: dict[tuple[int, str], str] = {}
        """Owners of structures, as shown to the user."""

    def claim(self, at: tuple[int, str], owner: str, key: str) -> None:
        """Give a structure to an owner. Raises ConfigError if it belongs to another one."""
        if at in self.used_by:
            raise ConfigError(
                f"{key}: {self.structures[at].name} is linked to {self.used_by[at]} already"
            )
        self.used_by[at] = owner

    def free(self) -> list[tuple[int, N]]:
        """Return the structures that belong to nothing, each with its port."""
        return [
            (port, each)
            for (port, name), each in self.structures.items()
            if (port, name) not in self.used_by
        ]


def placed_structures(
    variables: Iterable[PlacedVariable],
    is_wanted: _TypeTest,
    is_owner: _TypeTest = lambda type: False,
) -> list[PlacedStructure]:
    """Return the wanted structures among the variables that are at an address, by place.

    They may be in other structures and in arrays; the innermost around them that `is_owner` says
    yes to is their owner.
    """
    walk = _Walk(is_wanted, is_owner)
    structures = [
        each
        for placed in variables
        if walk.holds(placed.variable.type, placed.variable.address is not None)
        for each in walk.through(
            placed.variable.type,
            placed.name,
            "",
            placed.area,
            placed.offset,
            placed.variable.address is not None,
        )
    ]
    return sorted(structures, key=lambda each: (each.area.value, each.offset))


class _Walk:
    """Goes through types; what holds nothing is looked at once."""

    def __init__(self, is_wanted: _TypeTest, is_owner: _TypeTest) -> None:
        self._is_wanted, self._is_owner = is_wanted, is_owner
        self._holds_by_type: dict[int, bool] = {}

    def holds(self, type: IecType[Any], addressed: bool) -> bool:
        real = resolved(type)
        if isinstance(real, ArrayType):
            return self.holds(real.element, addressed)
        if not isinstance(real, StructType):
            return False
        if self._is_wanted(real):
            return addressed
        holds = self._holds_by_type.get(id(real))
        if holds is None:
            self._holds_by_type[id(real)] = (
                False  # while it is looked at: a type does not hold itself
            )
            holds = self._holds_by_type[id(real)] = any(
                self.holds(member.type, member.address is not None) for member in real.fields
            )
        return holds

    def through(
        self,
        type: IecType[Any],
        name: str,
        owner: str,
        area: Area,
        offset: int,
        addressed: bool,
    ) -> Iterator[PlacedStructure]:
        real = resolved(type)
        if isinstance(real, ArrayType):
            size = real.element.size
            ranges = (range(bounds.first, bounds.last + 1) for bounds in real.dimensions)
            for number, index in enumerate(product(*ranges)):
                each, at = f"{name}[{','.join(map(str, index))}]", offset + number * size
                yield from self.through(real.element, each, owner, area, at, addressed)
        elif isinstance(real, StructType):
            if self._is_wanted(real):
                if addressed:
                    yield PlacedStructure(name, owner or name, area, offset, real)
                return
            inner = name if self._is_owner(real) else ""
            for member in real.fields:
                if self.holds(member.type, member.address is not None):
                    yield from self.through(
                        member.type,
                        f"{name}.{member.name}",
                        inner,
                        area,
                        offset + member.offset,
                        member.address is not None,
                    )


def find_place(
    link: str,
    key: str,
    there: Mapping[tuple[int, str], NamedPlace],
    plcs: Mapping[int, PlcRuntime],
    kinds: str,
) -> tuple[int, str]:
    """Return the PLC and the variable of a link in the configuration.

    `link` is `851:MAIN.Axis1`, without port where that is clear, or a place (`%IB0`); `there` has
    the structures by port and name in small letters, `kinds` is what they are, for ConfigError.
    """
    head, colon, rest = link.partition(":")
    wanted = (rest if colon else link).strip().casefold()
    if colon and (not head.strip().isdecimal() or int(head) not in plcs):
        raise ConfigError(f"{key}: expected a PLC before the colon, got {link!r}")
    if at := _PLACE.fullmatch(wanted):
        here = _AREAS[at[1]], int(at[2])
        matches = {
            port: each.name.casefold()
            for (port, _), each in there.items()
            if (each.area, each.offset) == here
        }
    else:
        matches = {port: known for port, known in there if known == wanted}
    if colon:
        matches = {port: name for port, name in matches.items() if port == int(head)}
    if len(matches) == 1:
        return matches.popitem()
    if matches:
        first = next(iter(matches))
        raise ConfigError(f'{key}: {link} is in several PLCs, say which: "{first}:{link}"')
    names = [variable for at in there.values() for variable in (at.owner, at.name)]
    near = did_you_mean(rest if colon else link, names)
    raise ConfigError(
        f"{key}: no variable of the type {kinds} (AT %I*, AT %Q*) is named {link!r}{near}"
    )
