"""Slots: routines that the runtime calls by itself, as their attributes say.

Source: attributes `call_after_global_init_slot`, `call_after_online_change_slot` and
`call_on_type_change` of TwinCAT 3.
"""

import re
from collections.abc import Iterable, Mapping

from achse.st.typed.project import InitCall, Routine, TypeChangeCall

AFTER_GLOBAL_INIT = "call_after_global_init_slot"
AFTER_ONLINE_CHANGE = "call_after_online_change_slot"
_ON_TYPE_CHANGE = "call_on_type_change"

Notes = Mapping[str, Mapping[str, str]]
"""The attributes of routines, by the key of the routine and in lower case."""


def slot_of(note: Mapping[str, str]) -> str:
    """Return the attribute that has the runtime call a routine in a slot; empty without one."""
    for name in (AFTER_GLOBAL_INIT, AFTER_ONLINE_CHANGE):
        if note.get(name, "").strip().isdecimal():
            return name
    return ""


def slot_calls(name: str, routines: Iterable[Routine], notes: Notes) -> tuple[InitCall, ...]:
    """Return the routines with a slot of that attribute, in the order of their slots."""
    calls = []
    for routine in routines:
        slot = notes.get(routine.key, {}).get(name, "").strip()
        if slot.isdecimal():
            calls.append(InitCall(int(slot), routine.key, _block_of(routine)))
    return tuple(sorted(calls, key=lambda call: call.slot))


def type_change_calls(routines: Iterable[Routine], notes: Notes) -> tuple[TypeChangeCall, ...]:
    """Return the methods called for changed layouts of blocks; names are separated by `,` or
    `|`."""
    calls = []
    for routine in routines:
        named = notes.get(routine.key, {}).get(_ON_TYPE_CHANGE, "")
        types = frozenset(name.lower() for name in re.split(r"[,|\s]+", named) if name)
        if types and routine.this is not None:
            calls.append(TypeChangeCall(routine.key, _block_of(routine), types))
    return tuple(calls)


def _block_of(routine: Routine) -> str:
    return routine.owner if routine.this is not None else ""
