"""Project as lowering sees it: its routines and records, and the places of its variables."""

from collections.abc import Mapping
from typing import Any

from achse.iec.structs import StructType
from achse.plc.lowering.placement import Placement, Spot
from achse.st.typed.places import ImageBase, StaticBase, UnitBase
from achse.st.typed.project import Routine, TypedProject, TypedRecord


class LoweredProject:
    """A typed project in the memory of a PLC.

    `exceptions` is the task option "floating point exceptions". `counted` has the number of the
    first counter of each routine whose statements count; with `conditions` its decisions do, too.
    """

    def __init__(
        self,
        project: TypedProject,
        placement: Placement,
        *,
        exceptions: bool = True,
        counted: Mapping[str, int] | None = None,
        conditions: bool = False,
    ) -> None:
        self.typed = project
        self.placement = placement
        self.exceptions = exceptions
        self.counted = dict(counted or {})
        self.conditions = conditions
        records = (*project.blocks.values(), *project.records.values())
        self._records = {record.type.name.lower(): record for record in records}
        self._spots: dict[int, Spot] = {}

    def routine(self, key: str) -> Routine | str:
        """Return a routine; or, in words, why there is none."""
        match = self.typed.routines.get(key)
        if match is not None:
            return match
        return f"{key}: {self.typed.left_out.get(key, 'it has an error')}"

    def record(self, type: StructType[Any]) -> TypedRecord | None:
        """Return the row of a record whose values are created by code; None without any."""
        return self._records.get(type.name.lower())

    def spot(self, base: UnitBase | StaticBase | ImageBase) -> Spot:
        """Return the begin of a base. Raises `MissingPlaceError`."""
        if not isinstance(base, UnitBase):
            return self.placement.spot(base)
        spot = self._spots.get(id(base.variable))
        if spot is None:
            spot = self._spots[id(base.variable)] = self.placement.spot(base)
        return spot
