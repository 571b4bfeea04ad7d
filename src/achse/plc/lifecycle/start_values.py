"""Start values: what shows once every variable has its place is put over the initial values."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any

from achse.iec import ArrayType, DeclarationError, IecType, StructType, resolved
from achse.iec.variables import PointedValue, StartValue, Variable
from achse.plc.memory import Memory
from achse.plc.program import PlacedUnit, PlacedVariable


def put_start_values(
    units: Iterable[PlacedUnit],
    statics: Iterable[PlacedVariable],
    memory: Memory,
    *,
    of: type[IecType[Any]] = IecType,
    only: Collection[str] | None = None,
) -> tuple[str, ...]:
    """Work out the start values of all variables, unit by unit in the order of declaration.

    What a value is made of has its own start value only if that comes before. `of` picks those
    of one kind of type, `only` the variables of units by name in lower case. The result says, each
    once, what stays as its type says, and why.
    """
    units = list(units)
    return _Start(units, list(statics), memory, of).run(only)


class _Start:
    def __init__(
        self,
        units: Sequence[PlacedUnit],
        statics: list[PlacedVariable],
        memory: Memory,
        of: type[IecType[Any]],
    ) -> None:
        self._memory = memory
        self._statics = statics
        self._of = of
        self._units = units
        self._concerned: dict[int, bool] = {}
        self._skipped: dict[str, None] = {}

    def run(self, only: Collection[str] | None) -> tuple[str, ...]:
        for placed in self._statics if only is None else ():
            self._begin(placed.variable, self._spot(placed), PointedValue(placed.variable.type, 0))
        for unit in self._units:
            iec = type(unit.instance).__iec__
            for variable in iec.members:
                name = f"{unit.name}.{variable.name}"
                if only is not None and name.lower() not in only:
                    continue
                if variable.in_memory and (
                    variable.start_values or self._is_concerned(variable.type)
                ):
                    spot = self.variable(name)
                    self._begin(variable, spot, PointedValue(iec, 0))
        return tuple(self._skipped)

    # what start values see -------------------------------------------------------------------

    @cached_property
    def _names(self) -> dict[str, PlacedVariable]:
        return {one.name.lower(): one for unit in self._units for one in unit.variables}

    def variable(self, name: str) -> PointedValue:
        return self._spot(self._names[name.lower()])

    def read(self, address: int, size: int) -> bytes:
        place = self._memory.at(address)
        if place is None:
            raise LookupError(address)
        region, offset = place
        return region.read(offset, size)

    def _spot(self, placed: PlacedVariable) -> PointedValue:
        address = self._memory.address(placed.area, placed.offset)
        return PointedValue(placed.variable.type, address, placed.bit)

    @property
    def _is_whole(self) -> bool:
        """True if this initializes values of all kinds. Else values of one kind follow the values
        of their parts."""
        return self._of is IecType

    # one variable ----------------------------------------------------------------------------

    def _begin(self, variable: Variable[Any, Any], spot: PointedValue, own: PointedValue) -> None:
        """Initialise first the parts of a variable, then the variable itself.

        Members begin as their type says, so siblings see its values and not those of this one
        declaration: what FB_init does comes before the values of an instance, too.
        """
        if self._is_concerned(spot.type):
            said = variable.initial if isinstance(variable.initial, Mapping | list | tuple) else ()
            if said and self._is_whole:
                self._write(spot, None, spot.type.default)
            self._begin_inside(spot)
            if said and self._is_whole:
                memory = bytearray(self.read(spot.address, spot.type.size))
                spot.type.initialise(memory, 0, said)
                self._write(spot, None, bytes(memory))
            elif said:
                self._put_again(spot, said)
        for start in variable.start_values:
            if isinstance(resolved(start.type), self._of):
                self._put(start, spot, own)

    def _begin_inside(self, spot: PointedValue) -> None:
        real = resolved(spot.type)
        if isinstance(real, ArrayType):
            for index in range(real.count):
                self._begin_inside(
                    PointedValue(real.element, spot.address + index * real.element.size)
                )
        elif isinstance(real, StructType):
            for member in real.fields:
                place = PointedValue(member.type, spot.address + member.offset, member.bit)
                self._begin(member, place, PointedValue(real, spot.address))

    def _put_again(self, spot: PointedValue, initial: object) -> None:
        """Write the declared values again, over the start values of one kind."""
        real = resolved(spot.type)
        if not self._is_concerned(real):
            return
        if isinstance(real, StructType) and isinstance(initial, Mapping):
            for name, value in initial.items():
                member = real.member(name)
                place = PointedValue(member.type, spot.address + member.offset, member.bit)
                if self._is_concerned(member.type):
                    self._put_again(place, value)
                elif member.start_values and isinstance(resolved(member.type), self._of):
                    self._write(place, place.bit, member.type.encode(value))
        elif isinstance(real, ArrayType) and isinstance(initial, Sequence):
            flat = list(initial)
            for _ in real.counts[1:]:
                flat = [item for row in flat for item in row]
            for index, value in enumerate(flat):
                place = PointedValue(real.element, spot.address + index * real.element.size)
                self._put_again(place, value)

    def _is_concerned(self, type: IecType[Any]) -> bool:
        """Return True if a member of a type has a start value."""
        real = resolved(type)
        is_concerned = self._concerned.get(id(real))
        if is_concerned is None:
            if isinstance(real, ArrayType):
                is_concerned = self._is_concerned(real.element)
            else:
                is_concerned = isinstance(real, StructType) and any(
                    member.start_values or self._is_concerned(member.type) for member in real.fields
                )
            self._concerned[id(real)] = is_concerned
        return is_concerned

    def _put(self, start: StartValue, spot: PointedValue, own: PointedValue) -> None:
        try:
            data = start.value(self, own)
        except DeclarationError as left:
            self._skipped.setdefault(str(left))
            return
        bit = spot.bit if start.bit is None else start.bit
        self._write(spot._replace(address=spot.address + start.offset), bit, data)

    def _write(self, spot: PointedValue, bit: int | None, data: bytes) -> None:
        place = self._memory.at(spot.address)
        assert place is not None
        region, offset = place
        if bit is None:
            region.write(offset, data)
        else:
            region.write_bits(8 * offset + bit, data)
