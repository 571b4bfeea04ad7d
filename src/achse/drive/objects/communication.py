"""Communication objects 1000h to 1FFFh. Source: 001 §3.1, table 3.1.1 and 3.1.1.1 to 3.1.1.4."""

from collections.abc import Iterator

from achse.codes import AbortCode, DataType, SdoAbort
from achse.drive.identity import PRODUCT, VENDOR
from achse.drive.objects.row import DriveView, EntryAccess, ObjectRow
from achse.drive.record import ENTRIES

SAVE = 0x6576_6173
""""save": what 1010h:01 wants to see."""

RX_PDOS = range(0x1600, 0x1604)
TX_PDOS = range(0x1A00, 0x1A04)
RX_ASSIGNMENT = 0x1C12
TX_ASSIGNMENT = 0x1C13

DEFAULT_MAPPINGS = {
    0x1600: (0x60400010, 0x60600008, 0x60720010, 0x607A0020, 0x60B80010, 0x60FE0120),
    0x1601: (0x60400010, 0x60600008, 0x60FF0020, 0x60FE0120),
    0x1602: (0x60400010, 0x60600008, 0x60710010, 0x60FE0120),
    0x1603: (
        *(0x60400010, 0x60600008, 0x60710010, 0x60720010),
        *(0x607A0020, 0x60B80010, 0x60FF0020, 0x60FE0120),
    ),
    0x1A00: (
        *(0x603F0010, 0x60410010, 0x60610008, 0x60640020),
        *(0x60B90010, 0x60BA0020, 0x60F40020, 0x60FD0020),
    ),
    0x1A01: (
        *(0x603F0010, 0x60410010, 0x60610008, 0x60640020),
        *(0x606C0020, 0x60770010, 0x60FD0020),
    ),
    0x1A02: (
        *(0x603F0010, 0x60410010, 0x60610008, 0x60640020),
        *(0x606C0020, 0x60770010, 0x60FD0020),
    ),
    0x1A03: (
        *(0x60410010, 0x60610008, 0x60640020, 0x606C0020),
        *(0x60770010, 0x60B90010, 0x60BA0020, 0x60FD0020),
    ),
}
"""Default values of the mapping objects (001 §3.1.1)."""

CIA402_MAPPINGS = {
    0x1600: (0x60400010, 0x607A0020, 0x60FF0020, 0x60710010, 0x60600008),
    0x1A00: (0x60410010, 0x60640020, 0x606C0020, 0x60770010, 0x60610008, 0x60F40020, 0x603F0010),
}
"""Mappings that masters expect of any CiA 402 drive: set points and actual values of all cyclic
modes in the first PDOs."""

_U8, _U16, _U32 = DataType.U8, DataType.U16, DataType.U32


def _fixed(
    index: int, subindex: int, name: str, kind: DataType, value: int, doc: str, unit: str = ""
) -> ObjectRow:
    return ObjectRow(
        index,
        subindex,
        name,
        kind,
        EntryAccess.RO,
        doc,
        constant=value,
        default=value,
        minimum=value,
        maximum=value,
        unit=unit,
    )


def _save(drive: DriveView, value: int) -> None:
    if value != SAVE:
        raise SdoAbort(AbortCode.VALUE_RANGE)
    drive.save()


def _pdo_entry(
    index: int,
    subindex: int,
    name: str,
    kind: DataType,
    doc: str,
    default: int,
    minimum: int | None = None,
    maximum: int | None = None,
    judged_by_write: bool = False,
) -> ObjectRow:
    """Return a row whose value the mapping holds; its 8 steps and abort codes are there."""

    def read(drive: DriveView) -> int:
        return drive.mapping.read(index, subindex)

    def write(drive: DriveView, value: int) -> None:
        drive.mapping.write(index, subindex, value)

    return ObjectRow(
        index,
        subindex,
        name,
        kind,
        EntryAccess.RW_PREOP,
        doc,
        default=default,
        minimum=minimum,
        maximum=maximum,
        stored=True,
        read=read,
        write=write,
        judged_by_write=judged_by_write,
    )


_ORDINALS = ("1st", "2nd", "3rd", "4th")


def _mappings() -> Iterator[ObjectRow]:
    for pdos, kind in ((RX_PDOS, "RxPDO"), (TX_PDOS, "TxPDO")):
        for ordinal, index in zip(_ORDINALS, pdos, strict=True):
            name = f"{ordinal} {kind} mapping"
            entries = DEFAULT_MAPPINGS[index]
            yield _pdo_entry(
                index,
                0,
                f"{name}: Number of entries",
                _U8,
                "Valid entries; 0 before any of them may be changed, PreOp only.",
                len(entries),
                maximum=ENTRIES,
                judged_by_write=True,
            )
            for number in range(1, ENTRIES + 1):
                yield _pdo_entry(
                    index,
                    number,
                    f"{name}: Mapping entry {number}",
                    _U32,
                    "Index << 16 | subindex << 8 | bits of the mapped object.",
                    entries[number - 1] if number <= len(entries) else 0,
                )


def _assignments() -> Iterator[ObjectRow]:
    for index, number, kind, pdos in (
        (RX_ASSIGNMENT, 2, "RxPDO", RX_PDOS),
        (TX_ASSIGNMENT, 3, "TxPDO", TX_PDOS),
    ):
        name = f"SyncManager {number} PDO assignment"
        yield _pdo_entry(
            index,
            0,
            f"{name}: Number of assigned PDOs",
            _U8,
            "0 or 1; 0 before the mapping may be changed, 1 checks it.",
            1,
            maximum=1,
        )
        yield _pdo_entry(
            index,
            1,
            f"{name}: Index of assigned {kind} 1",
            _U16,
            f"Mapping object of SyncManager {number}.",
            pdos[0],
            pdos[0],
            pdos[-1],
        )


def _synchronisation(index: int, number: int, count: int) -> tuple[ObjectRow, ...]:
    name = f"SyncManager {number} synchronization"
    side = "outputs" if number == 2 else "inputs"
    return (
        _fixed(
            index,
            0,
            f"{name}: Number of synchronization parameters",
            _U8,
            count,
            "Entries as the source counts them.",
        ),
        ObjectRow(
            index,
            1,
            f"{name}: Synchronization type",
            _U16,
            EntryAccess.RO,
            f"How the {side} are synchronised: 0 FreeRun, 2 DC with Sync0.",
            "sync_type",
            maximum=2,
            values=(0, 2),
        ),
        ObjectRow(
            index,
            2,
            f"{name}: Cycle time",
            _U32,
            EntryAccess.RO,
            "Local timer in FreeRun, Sync0 cycle with DC.",
            "sync_cycle",
            250_000,
            "ns",
            minimum=250_000,
            maximum=4_000_000,
        ),
        _fixed(
            index,
            4,
            f"{name}: Synchronization types supported",
            _U16,
            5,
            "Bit 0 FreeRun, bits 2 to 4 = 001b DC with Sync0.",
        ),
        _fixed(
            index, 5, f"{name}: Minimum cycle time", _U32, 187_500, "Shortest local cycle.", "ns"
        ),
        _fixed(
            index,
            6,
            f"{name}: Calc and copy time",
            _U32,
            31_250,
            f"Time between the {side} and the sync event.",
            "ns",
        ),
        _fixed(index, 9, f"{name}: Delay time", _U32, 31_250, "Delay of the hardware.", "ns"),
        ObjectRow(
            index,
            11,
            f"{name}: SM event missed",
            _U16,
            EntryAccess.RO,
            "SM2 events that did not come in their Sync0 cycle since Op was entered (ETG.1020).",
            read=lambda drive: drive.missed_events,
        ),
        ObjectRow(
            index,
            12,
            f"{name}: Cycle time too small",
            _U16,
            EntryAccess.RO,
            "Sync0 cycles that were too short for the local cycle.",
            "cycle_too_small",
            minimum=0,
            maximum=0,
        ),
        ObjectRow(
            index,
            32,
            f"{name}: Sync error",
            _U8,
            EntryAccess.RO,
            "1 when synchronisation was lost in Op, until Op is entered again (ETG.1020).",
            maximum=1,
            read=lambda drive: int(drive.sync_error),
        ),
    )


COMMUNICATION = (
    _fixed(0x1000, 0, "Device type", _U32, 0x0002_0192, "Servo drive of profile 402."),
    ObjectRow(
        0x1001,
        0,
        "Error register",
        _U8,
        EntryAccess.RO,
        "Bit 0 while an error is present.",
        "error_register",
    ),
    _fixed(0x1010, 0, "Store parameters: Number of entries", _U8, 1, "One group of parameters."),
    ObjectRow(
        0x1010,
        1,
        "Store parameters: Save all parameters",
        _U32,
        EntryAccess.RW,
        'Writing "save" stores all parameters; reads 0 while that takes, else 1.',
        default=1,
        read=lambda drive: 0 if drive.storing else 1,
        write=_save,
    ),
    _fixed(0x1018, 0, "Identity object: Number of entries", _U8, 4, "Numbers of identity."),
    ObjectRow(
        0x1018,
        1,
        "Identity object: Vendor ID",
        _U32,
        EntryAccess.RO,
        "EtherCAT vendor number: of no maker; the manual's is 0xAAAA.",
        default=VENDOR,
        read=lambda drive: int(drive.identity.vendor_id),
    ),
    ObjectRow(
        0x1018,
        2,
        "Identity object: Product code",
        _U32,
        EntryAccess.RO,
        "Code of the drive family; the manual's is 5.",
        default=PRODUCT,
        read=lambda drive: int(drive.identity.product_code),
    ),
    ObjectRow(
        0x1018,
        3,
        "Identity object: Revision number",
        _U32,
        EntryAccess.RO,
        "Revision of the device.",
        default=0x0001_0000,
        read=lambda drive: int(drive.identity.revision_number),
    ),
    ObjectRow(
        0x1018,
        4,
        "Identity object: Serial number",
        _U32,
        EntryAccess.RO,
        "Serial number of the device.",
        default=1,
        read=lambda drive: int(drive.identity.serial_number),
    ),
    _fixed(0x10F1, 0, "Error settings: Number of entries", _U8, 1, "As the source counts it."),
    ObjectRow(
        0x10F1,
        2,
        "Error settings: Sync error counter limit",
        _U16,
        EntryAccess.RW,
        "Missed SM2 events count 3, received ones -1; AL status 0x1A at this limit, 0 never.",
        "sync_error_limit",
        maximum=15,
        stored=True,
    ),
    _fixed(0x10F3, 0, "Diagnosis history: Number of entries", _U8, 5, "The flags are last."),
    ObjectRow(
        0x10F3,
        5,
        "Diagnosis history: Flags",
        _U16,
        EntryAccess.RW,
        "Bit 0: emergencies are sent (001 §2.7, which has no table of it; place as in ETG.1020).",
        "diagnosis_flags",
        default=1,
        maximum=1,
        stored=True,
    ),
    *_mappings(),
    _fixed(0x1C00, 0, "SyncManager communication type: Number of entries", _U8, 4, "SyncManagers."),
    *(
        _fixed(
            0x1C00,
            number + 1,
            f"SyncManager communication type: Communication type SyncManager {number}",
            _U8,
            number + 1,
            meaning,
        )
        for number, meaning in enumerate(
            ("Mailbox from the master.", "Mailbox to the master.", "Outputs.", "Inputs.")
        )
    ),
    *_assignments(),
    *_synchronisation(0x1C32, 2, 12),
    *_synchronisation(0x1C33, 3, 10),
)
