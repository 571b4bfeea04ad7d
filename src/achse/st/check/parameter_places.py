"""Storages of parameters: in the frame of the called routine, or in the unit of a program."""

from typing import Any

from achse.iec.variables import Variable
from achse.st.check.signatures import DeclaredParameter
from achse.st.typed.places import CalleeBase, Storage, UnitBase, flat

_CALLEE = CalleeBase()


def place_of(parameter: DeclaredParameter, at: int, unit: str = "") -> Storage:
    """Return the storage of a parameter in the called routine, of a program in its unit."""
    variable = parameter.variable
    type = flat(variable.type)
    if unit:
        return Storage(UnitBase(unit, variable), 0, type, name=variable.name, at=at)
    return Storage(_CALLEE, variable.offset, type, variable.bit, (), False, variable.name, at)


def place_of_variable(variable: Variable[Any, Any], at: int) -> Storage:
    """Return the storage of a variable of the called routine."""
    type = flat(variable.type)
    return Storage(_CALLEE, variable.offset, type, name=variable.name, at=at)


def place_beside(place: Storage, variable: Any) -> Storage:
    """Return the storage of the hidden variable beside a parameter."""
    type = flat(variable.type)
    if isinstance(place.base, UnitBase):
        return Storage(UnitBase(place.base.unit, variable), 0, type, name=variable.name)
    return Storage(place.base, variable.offset, type, name=variable.name, at=place.at)
