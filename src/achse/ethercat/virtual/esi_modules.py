"""Modules in the slots of a modular device: PDOs and objects moved to the place of their slot.

Source: ETG.2000, Slots of a device and Descriptions/Modules; ETG.5001.1 for F030h and F050h.
"""

from collections.abc import Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from itertools import islice
from xml.etree.ElementTree import Element

from achse.ethercat.dictionary import DictionaryObject
from achse.ethercat.master.esi_reader import (
    EsiDevice,
    EsiError,
    coe_commands,
    idn_commands,
    read_pdo,
)
from achse.ethercat.master.xml_document import flag, number_of
from achse.ethercat.virtual.esi_dictionary import read_dictionary

_LAST_INDEX = 0xFFFF
_MOST_MODULES = 0xFF
"""Modules that F030h and F050h can list."""


@dataclass(frozen=True)
class EquippedDevice:
    """A device with modules in its slots; `idents` is None for one without slots."""

    device: EsiDevice
    idents: tuple[int, ...] | None = None
    objects: tuple[DictionaryObject, ...] = ()


def module_names(device: EsiDevice) -> list[str]:
    """Return the names of all modules in the file of a device."""
    return [_name(each) for each in _modules(device)]


def equip(device: EsiDevice, names: Sequence[str] = ()) -> EquippedDevice:
    """Return the device with these modules in its slots, the first in the first slot.

    Without names the slots have their default modules. Raises `EsiError` for a module that the file
    has not, and for a device without slots.
    """
    slots = None if device.element is None else device.element.find("Slots")
    if slots is None:
        if names:
            raise EsiError(f"{device.type_name} has no slots for modules")
        return EquippedDevice(device)
    try:
        chosen = [_named(device, each) for each in names] or list(
            islice(_default(device, slots), _MOST_MODULES + 1)
        )
        if len(chosen) > _MOST_MODULES:
            raise EsiError(f"{device.type_name}: {_MOST_MODULES} modules at most, there are more")
        steps = [
            number_of(slots.get(key) or "0", key)
            for key in ("SlotPdoIncrement", "SlotIndexIncrement")
        ]
        outputs, inputs = list(device.outputs), list(device.inputs)
        commands, idn_writes = list(device.commands), list(device.idn_commands)
        objects: dict[int, DictionaryObject] = {}
        for place, module in enumerate(chosen):
            moved = [place * step for step in steps]
            for tag, side in (("RxPdo", outputs), ("TxPdo", inputs)):
                side += [read_pdo(_moved(each, *moved)) for each in module.findall(tag)]
            coe = module.find("Mailbox/CoE")
            if coe is not None:
                commands += coe_commands(_moved(coe, *moved))
            idn_writes += idn_commands(module.find("Mailbox/SoE"))
            for each in read_dictionary(iter(module.findall("Profile")), moved[1]):
                objects.setdefault(each.index, each)
        idents = tuple(_ident(each) for each in chosen)
    except EsiError:
        raise
    except ValueError as fault:
        raise EsiError(f"{device.type_name}: {fault}") from None
    equipped = replace(
        device,
        outputs=tuple(outputs),
        inputs=tuple(inputs),
        commands=tuple(commands),
        idn_commands=tuple(idn_writes),
    )
    return EquippedDevice(equipped, idents, tuple(objects.values()))


def _modules(device: EsiDevice) -> Iterator[Element]:
    yield from () if device.modules is None else device.modules.iterfind("Module")


def _name(module: Element) -> str:
    return (module.findtext("Type") or "").strip()


def _ident(module: Element) -> int:
    kind = module.find("Type")
    text = "0" if kind is None else kind.get("ModuleIdent", "0")
    return number_of(text, "ModuleIdent") & 0xFFFF_FFFF


def _named(device: EsiDevice, name: str) -> Element:
    for each in _modules(device):
        if _name(each) == name:
            return each
    there = ", ".join(module_names(device)[:20]) or "none"
    raise EsiError(f"{device.type_name}: no module {name!r}; there are: {there}")


def _default(device: EsiDevice, slots: Element) -> Iterator[Element]:
    """Yield the modules that the slots have by themselves."""
    known = {_ident(each): each for each in _modules(device)}
    for slot in slots.iterfind("Slot"):
        for each in slot.iterfind("ModuleIdent"):
            ident = number_of((each.text or "").strip(), "ModuleIdent")
            if flag(each, "Default") and ident in known:
                yield known[ident]


def _moved(pdo: Element, pdo_step: int, index_step: int) -> Element:
    """PDOs or start commands of a module as they are in its slot."""
    copied = deepcopy(pdo)
    for path, step in (
        ("Index", pdo_step), ("Exclude", pdo_step), ("Entry/Index", index_step),
        ("InitCmd/Index", index_step),
    ):  # fmt: skip
        for each in copied.iterfind(path):
            if flag(each, "DependOnSlot"):
                index = number_of((each.text or "").strip(), path) + step
                if not 0 < index <= _LAST_INDEX:
                    raise ValueError(f"{path}: expected 1 to 0xFFFF, got {index}")
                each.text = str(index)
    return copied
