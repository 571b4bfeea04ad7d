"""Slaves without mailboxes, by the bits of their process data."""

from typing import Any

from achse.ethercat.description import Pdo, PdoEntry
from achse.ethercat.master.configuration import ProcessSyncManager, SlaveConfiguration

__all__ = ["box"]


def box(
    outputs: int, inputs: int, unit: str = "", lrw: bool = True, **more: Any
) -> SlaveConfiguration:
    """A slave with so many bits, an entry each."""

    def pdo(index: int, manager: int, bits: int) -> tuple[Pdo, ...]:
        entries = tuple(PdoEntry(0x6000, 1 + n, 1, "", 1) for n in range(bits))
        return (Pdo(index, "", manager, True, entries),) if bits else ()

    return SlaveConfiguration(
        "box",
        sync_managers=(
            ProcessSyncManager(2, 0x1100, 0x64, True),
            ProcessSyncManager(3, 0x1180, 0x20, False),
        ),
        outputs=pdo(0x1600, 2, outputs),
        inputs=pdo(0x1A00, 3, inputs),
        sync_unit=unit,
        logical_read_write=lrw,
        **more,
    )
