"""ESI files of the tests' own, as text: one device at a time, and devices that are drawn."""

from typing import Any

from hypothesis import strategies as st

VENDOR = 0xE51
TYPES = {"BOOL": 1, "SINT": 8, "USINT": 8, "INT": 16, "UINT": 16, "DINT": 32, "UDINT": 32,
         "REAL": 32, "LREAL": 64, "ULINT": 64, "BIT3": 3}  # fmt: skip


def pdo(tag: str, index: int, entries: list[tuple[int, int, int, str, str]], **options: Any) -> str:
    """A PDO; entries are index, subindex, bits, name, type, options attributes and `excludes`."""
    excludes = options.pop("excludes", ())
    attributes = " ".join(f'{key}="{value}"' for key, value in options.items())
    rows = "".join(
        f"<Entry><Index>#x{entry:04X}</Index><SubIndex>{sub}</SubIndex><BitLen>{bits}</BitLen>"
        f"<Name>{name}</Name><DataType>{kind}</DataType></Entry>"
        if entry
        else f"<Entry><Index>0</Index><BitLen>{bits}</BitLen></Entry>"
        for entry, sub, bits, name, kind in entries
    )
    banned = "".join(f"<Exclude>#x{each:04X}</Exclude>" for each in excludes)
    name = f"PDO {index:04X}"
    return (
        f"<{tag} {attributes}><Index>#x{index:04X}</Index><Name>{name}</Name>{banned}{rows}</{tag}>"
    )


def device(
    body: str,
    *,
    name: str = "Box",
    product: int = 0x1001,
    revision: int = 0x10000,
    physics: str = "YY",
) -> str:
    """A device around its elements."""
    return (
        f'<Device Physics="{physics}"><Type ProductCode="#x{product:08X}"'
        f' RevisionNo="#x{revision:08X}">{name}</Type><Name LcId="1033">{name}, tested</Name>'
        f"<GroupType>Boxes</GroupType>{body}</Device>"
    )


def esi(*devices: str, modules: str = "") -> str:
    """A file with these devices."""
    return (
        f"<EtherCATInfo><Vendor><Id>#x{VENDOR:X}</Id><Name>tests</Name></Vendor><Descriptions>"
        f"<Devices>{''.join(devices)}</Devices><Modules>{modules}</Modules></Descriptions>"
        "</EtherCATInfo>"
    )


MAILBOX = (
    '<Sm DefaultSize="128" StartAddress="#x1000" ControlByte="#x26" Enable="1">MBoxOut</Sm>'
    '<Sm DefaultSize="128" StartAddress="#x1080" ControlByte="#x22" Enable="1">MBoxIn</Sm>'
)
OUTPUTS = '<Sm StartAddress="#x1100" ControlByte="#x64" Enable="1">Outputs</Sm>'
INPUTS = '<Sm StartAddress="#x1800" ControlByte="#x20" Enable="1">Inputs</Sm>'
COE = '<Mailbox DataLinkLayer="1"><CoE SdoInfo="1" PdoAssign="1" PdoConfig="1" CompleteAccess="1"/>'

COUPLER = device(
    "<Eeprom><ByteSize>2048</ByteSize><ConfigData>040D000000000000</ConfigData></Eeprom>",
    name="EK",
    product=0x1100,
    physics="YKY",
)
"""Neither process data nor a mailbox."""

DIGITAL_IN = device(
    "<Fmmu>Inputs</Fmmu>"
    '<Sm DefaultSize="1" StartAddress="#x1000" ControlByte="0" Enable="1">Inputs</Sm>'
    + "".join(
        pdo("TxPdo", 0x1A00 + n, [(0x6000 + 16 * n, 1, 1, "Input", "BOOL")], Fixed=1, Sm=0)
        for n in range(8)
    )
    + "<Eeprom><ByteSize>2048</ByteSize><ConfigData>0401000000000000</ConfigData></Eeprom>",
    name="DI8",
    product=0x1008,
    physics="KK",
)
"""Eight inputs behind a controller without a program."""

DIGITAL_OUT = device(
    "<Fmmu>Outputs</Fmmu>"
    '<Sm DefaultSize="1" StartAddress="#x0F00" ControlByte="#x44" Enable="1">Outputs</Sm>'
    + "".join(
        pdo("RxPdo", 0x1600 + n, [(0x7000 + 16 * n, 1, 1, f"Lamp {n}", "BOOL")], Fixed=1, Sm=0)
        for n in range(8)
    )
    + "<Eeprom><ByteSize>2048</ByteSize><ConfigData>0401000000000000</ConfigData></Eeprom>",
    name="DO8",
    product=0x2008,
    physics="KK",
)
"""Eight outputs behind a controller without a program."""

ANALOG = device(
    MAILBOX
    + OUTPUTS.replace("#x1100", "#x1100")
    + INPUTS
    + pdo("RxPdo", 0x1600, [(0x7000, 1, 16, "Valve", "INT")], Sm=2)
    + pdo("TxPdo", 0x1A00, [(0x6000, 1, 16, "Status", "UINT"), (0x6000, 2, 16, "Value", "INT")],
          Sm=3, excludes=[0x1A01])
    + pdo("TxPdo", 0x1A01, [(0x6000, 2, 16, "Value", "INT")], excludes=[0x1A00])
    + pdo("TxPdo", 0x1A02, [(0x6010, 1, 32, "Level", "REAL")], Fixed=1)
    + COE + "<FoE/></Mailbox>"
    "<Dc><OpMode><Name>DC</Name><AssignActivate>#x0300</AssignActivate>"
    '<CycleTimeSync0 Factor="1">0</CycleTimeSync0></OpMode></Dc>'
    "<Eeprom><ByteSize>2048</ByteSize><ConfigData>050603446400</ConfigData></Eeprom>",
    name="AIO",
    product=0x3001,
)  # fmt: skip
"""An analog terminal with alternatives, FoE and a clock."""


@st.composite
def drawn_devices(draw: st.DrawFn) -> str:
    """A device with drawn process data, mailbox, modes and configuration."""
    mailbox = draw(st.booleans())
    first = 2 if mailbox else 0
    kinds = st.sampled_from(sorted(TYPES))
    managers: list[str] = []
    pdos: list[str] = []
    place = first
    for tag, use, control, base, start in (
        ("RxPdo", "Outputs", 0x64, 0x7000, 0x1200),
        ("TxPdo", "Inputs", 0x20, 0x6000, 0x2400),
    ):
        for _ in range(draw(st.integers(0, 2))):
            managers.append(
                f'<Sm StartAddress="#x{start:04X}" ControlByte="#x{control:02X}" Enable="1">'
                f"{use}</Sm>"
            )
            for _ in range(draw(st.integers(0, 3))):
                index = (0x1600 if tag == "RxPdo" else 0x1A00) + len(pdos)
                entries = [
                    (base + 16 * len(pdos), n, TYPES[kind], f"Entry {n}", kind)
                    for n, kind in enumerate(draw(st.lists(kinds, min_size=1, max_size=4)), 1)
                ]
                if draw(st.booleans()):
                    entries.append((0, 0, draw(st.integers(1, 16)), "", ""))
                fixed = draw(st.sampled_from([{}, {"Fixed": 1}]))
                pdos.append(pdo(tag, index, entries, Sm=place, **fixed))
            place += 1
            start += 0x600
    speaks = ""
    if mailbox:
        flags = " ".join(
            f'{key}="{int(draw(st.booleans()))}"'
            for key in ("SdoInfo", "PdoAssign", "PdoConfig", "CompleteAccess")
        )
        others = draw(st.lists(st.sampled_from(["FoE", "EoE", "SoE", "VoE"]), unique=True))
        coe = f"<CoE {flags}/>" if draw(st.booleans()) else ""
        speaks = f"<Mailbox>{coe}{''.join(f'<{each}/>' for each in others)}</Mailbox>"
    activate = draw(st.sampled_from([0, 0x300, 0x700]))
    clock = draw(st.booleans())
    modes = (
        f"<Dc><OpMode><Name>M</Name><AssignActivate>{activate}</AssignActivate></OpMode></Dc>"
        if clock
        else ""
    )
    emulated = 0 if mailbox else draw(st.integers(0, 1))
    return device(
        (MAILBOX if mailbox else "") + "".join(managers) + "".join(pdos) + speaks + modes
        + f"<Eeprom><ByteSize>{draw(st.sampled_from([256, 2048]))}</ByteSize>"
        f"<ConfigData>05{emulated:02X}03446400</ConfigData></Eeprom>",
        name=draw(st.sampled_from(["A", "Box-1", "Ünit"])),
        physics=draw(st.sampled_from(["YY", "KK", "YKY", "Y"])),
    )  # fmt: skip
