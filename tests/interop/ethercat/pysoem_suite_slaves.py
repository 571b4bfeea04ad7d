"""The slaves that pysoem's own tests were written for, in an ESI file of ours, with behaviours.

Identities, objects and process data are those that its tests ask for.
"""

from pathlib import Path

from achse.codes import AbortCode, FileRefusal, FoeError, SdoAbort
from achse.ethercat.virtual import SlaveBehaviour, VirtualDevice
from tests.ethercat.virtual.esi_text import COE, INPUTS, MAILBOX, OUTPUTS, device, pdo

BECKHOFF, EK1100, EL3002, EL1259, XMC = 2, 0x044C2C52, 0x0BBA3052, 0x04EB3052, 0x12783456
COUNT = 8
EMERGENCY = bytes.fromhex("fe ff 00 aa 50 51 52 53")
CONFIG = "<Eeprom><ByteSize>2048</ByteSize><ConfigData>050603446400</ConfigData></Eeprom>"
TRIGGER = """<Profile><Dictionary><DataTypes><DataType><Name>DT8001</Name><BitSize>48</BitSize>
<SubItem><SubIdx>0</SubIdx><Name>Count</Name><Type>USINT</Type><BitSize>8</BitSize></SubItem>
<SubItem><SubIdx>1</SubIdx><Name>Trigger</Name><Type>UDINT</Type><BitSize>32</BitSize>
<Flags><Access>rw</Access></Flags></SubItem></DataType>
<DataType><Name>DT8001S</Name><BitSize>32</BitSize>
<SubItem><SubIdx>0</SubIdx><Name>Count</Name><Type>USINT</Type><BitSize>8</BitSize></SubItem>
<SubItem><SubIdx>2</SubIdx><Name>Mode</Name><Type>USINT</Type><BitSize>8</BitSize>
<Flags><Access>rw</Access></Flags></SubItem></DataType></DataTypes>
<Objects><Object><Index>#x8001</Index><Name>Settings</Name><Type>{kind}</Type></Object></Objects>
</Dictionary></Profile>"""


def stamps() -> str:
    """Channels with a bit of output (12 bytes each) and a bit that tells it (4 bytes each)."""
    rows = []
    for n in range(COUNT):
        out = [(0x7001 + 16 * n, 1, 1, "Reset", "BOOL"), (0x7001 + 16 * n, 2, 1, "Output", "BOOL")]
        rows.append(pdo("RxPdo", 0x1603 + 4 * n, [*out, (0, 0, 94, "", "")], Sm=2))
        back = [(0, 0, 2, "", ""), (0x6001 + 16 * n, 3, 1, "State", "BOOL"), (0, 0, 29, "", "")]
        rows.append(pdo("TxPdo", 0x1A00 + n, back, Sm=3))
    for n in range(COUNT):
        control = [(0x7081 + 16 * n, 1, 8, "Control", "USINT")]
        rows.append(pdo("RxPdo", 0x1620 + n, control, Sm=2))
        count = [(0x6081 + 16 * n, 1, 16, "Count", "UINT")]
        rows.append(pdo("TxPdo", 0x1A08 + 4 * n, count, Sm=3))
    return "".join(rows)


def esi_of(vendor: int, *devices: str) -> str:
    """A file of one vendor."""
    return (
        f"<EtherCATInfo><Vendor><Id>{vendor}</Id></Vendor><Descriptions><Devices>"
        f"{''.join(devices)}</Devices></Descriptions></EtherCATInfo>"
    )


def write_files(folder: Path) -> None:
    """The two ESI files."""
    mailbox = COE + "</Mailbox>"
    clock = "<Dc><OpMode><Name>DC</Name><AssignActivate>#x300</AssignActivate></OpMode></Dc>"
    analog = pdo("TxPdo", 0x1A00, [(0x6000, 0x11, 16, "Value", "INT")], Sm=3)
    (folder / "terminals.xml").write_text(
        esi_of(
            BECKHOFF,
            device(CONFIG, name="EK1100", product=EK1100),
            device(
                MAILBOX + OUTPUTS + INPUTS + analog + mailbox + CONFIG,
                name="EL3002",
                product=EL3002,
            ),
            device(
                TRIGGER.format(kind="DT8001S")
                + (MAILBOX + OUTPUTS + INPUTS + stamps() + mailbox + clock + CONFIG),
                name="EL1259",
                product=EL1259,
            ),
        )
    )
    (folder / "board.xml").write_text(
        esi_of(
            0,
            device(
                TRIGGER.format(kind="DT8001")
                + (MAILBOX + OUTPUTS + INPUTS + COE + "<FoE/></Mailbox>" + CONFIG),
                name="XMC43-Test-Device",
                product=XMC,
            ),
        )
    )


class Board(SlaveBehaviour):
    """Sends an emergency when its trigger is written; has room for one file."""

    def write(self, device: VirtualDevice, index: int, subindex: int, data: bytes) -> None:
        if index == 0x8001:
            device.emergencies.append(EMERGENCY)

    def begin_file(self, device: VirtualDevice, name: str, password: int) -> None:
        if name != "test.bin":
            raise FileRefusal(FoeError.NOT_FOUND, name)


class Stamps(SlaveBehaviour):
    """Tells each output at the input beside it."""

    def step(self, device: VirtualDevice, elapsed_ns: int) -> None:
        for n in range(COUNT):
            stamp, done = f"{0x6001 + 16 * n:04X}:03", f"{0x7001 + 16 * n:04X}:02"
            device.set_input(stamp, device.output(done))

    def write(self, device: VirtualDevice, index: int, subindex: int, data: bytes) -> None:
        if index == 0x1008:
            raise SdoAbort(AbortCode.LOCAL_CONTROL)
