"""The ESI file says what the SII image and the dictionary say."""

from xml.etree import ElementTree

import pytest

from achse.codes import DataType
from achse.drive import Drive
from achse.ethercat import Loopback, ObjectAccess, ObjectEntry, Slave, build_sii, describe
from achse.ethercat.esi import build_esi

Element = ElementTree.Element

SEQUENCE = (
    "Type Name Info GroupType Profile Fmmu Fmmu Fmmu Sm Sm Sm Sm RxPdo TxPdo Mailbox Dc Eeprom"
)
"""Elements of a device in the order of EtherCATInfo.xsd."""


@pytest.fixture
def device() -> Element:
    text = build_esi(describe(Loopback(4)), vendor="nobody")
    match = ElementTree.fromstring(text.encode()).find("Descriptions/Devices/Device")
    assert match is not None
    return match


@pytest.fixture
def servo() -> Element:
    """The description of a drive: many objects, several PDOs."""
    esi = build_esi(describe(Drive()), vendor="nobody")
    match = ElementTree.fromstring(esi.encode()).find("Descriptions/Devices/Device")
    assert match is not None
    return match


def text(parent: Element, path: str) -> str:
    result = parent.findtext(path)
    assert result is not None, path
    return result


def hexadecimal(value: str) -> int:
    assert value.startswith("#x")
    return int(value[2:], 16)


def test_the_elements_come_in_the_schemas_order(device: Element) -> None:
    assert " ".join(child.tag for child in device) == SEQUENCE


def test_identity(device: Element) -> None:
    kind = device.find("Type")
    assert kind is not None
    assert kind.text == "loopback"
    assert hexadecimal(kind.attrib["ProductCode"]) == 0x100B
    assert hexadecimal(kind.attrib["RevisionNo"]) == 1


def test_the_controller_is_the_one_that_answers(device: Element) -> None:
    memory = Slave(Loopback(4)).esc.memory
    info = device.find("Info")
    assert info is not None
    assert [each.tag for each in info] == ["StateMachine", "Mailbox", "EtherCATController"]
    controller = info[2]
    assert int(text(controller, "FmmuCount")) == memory[0x0004]
    assert int(text(controller, "SmCount")) == memory[0x0005]
    assert int(text(controller, "DpramSize")) == 1024 * memory[0x0006]


def test_sync_managers(device: Element) -> None:
    rows = [
        (
            row.text,
            hexadecimal(row.attrib["StartAddress"]),
            int(row.attrib["DefaultSize"]),
            hexadecimal(row.attrib["ControlByte"]),
        )
        for row in device.iter("Sm")
    ]
    assert rows == [
        ("MBoxOut", 0x1000, 256, 0x26),
        ("MBoxIn", 0x1100, 256, 0x22),
        ("Outputs", 0x1200, 4, 0x64),
        ("Inputs", 0x1300, 4, 0x20),
    ]


def test_pdos_fill_the_sync_managers(device: Element) -> None:
    for tag, sync_manager in (("RxPdo", "2"), ("TxPdo", "3")):
        pdo = device.find(tag)
        assert pdo is not None
        assert pdo.attrib == {"Sm": sync_manager, "Fixed": "1"}
        assert sum(int(bits.text or 0) for bits in pdo.iter("BitLen")) == 32
        assert {each.text for each in pdo.iter("DataType")} == {"USINT"}


def test_the_dictionary_is_whole(device: Element) -> None:
    objects = device.findall("Profile/Dictionary/Objects/Object")
    expected = Loopback(4).objects()
    assert [hexadecimal(text(each, "Index")) for each in objects] == [
        each.index for each in expected
    ]
    types = {
        text(each, "Name") for each in device.iter("DataType") if each.find("Name") is not None
    }
    assert {text(each, "Type") for each in objects} <= types
    for each in device.iter("SubItem"):
        if each.find("Type") is not None:
            assert text(each, "Type") in types


def test_offsets_in_a_record_are_those_of_complete_access(device: Element) -> None:
    for kind in device.iter("DataType"):
        items = kind.findall("SubItem")
        if items:
            offsets = [int(text(item, "BitOffs")) for item in items]
            sizes = [int(text(item, "BitSize")) for item in items]
            assert offsets[:2] == [0, 16]
            assert all(
                offset + size == after
                for offset, size, after in zip(offsets[1:], sizes[1:], offsets[2:], strict=False)
            )
            assert offsets[-1] + sizes[-1] == int(text(kind, "BitSize"))


def test_clock_modes(device: Element) -> None:
    words = [hexadecimal(each.text or "") for each in device.iter("AssignActivate")]
    assert words == [0x0000, 0x0300]


def test_the_configuration_data_are_the_images(device: Element) -> None:
    assert text(device, "Eeprom/ConfigData") == build_sii(describe(Loopback(4)))[:14].hex().upper()
    assert text(device, "Eeprom/ByteSize") == "4096"


NAMES = {"USINT": 5, "UINT": 6, "UDINT": 7, "SINT": 2, "INT": 3, "DINT": 4, "REAL": 8}


def described(info: Element, flags: Element | None) -> tuple[object, ...]:
    """Limits, default and flags of an entry as the file has them."""
    access = None if flags is None else flags.find("Access")
    assert flags is not None
    assert access is not None
    return (
        *(bytes.fromhex(text(info, tag)) for tag in ("MinData", "MaxData", "DefaultData")),
        access.text,
        access.get("WriteRestrictions"),
        flags.findtext("PdoMapping"),
        flags.findtext("Backup"),
    )


def expected(entry: ObjectEntry) -> tuple[object, ...]:
    """The same from the dictionary."""
    access = entry.access
    preop = access & ObjectAccess.WRITE == ObjectAccess.WRITE_PREOP
    mappable = "R" * bool(access & ObjectAccess.RX_PDO) + "T" * bool(access & ObjectAccess.TX_PDO)
    return (
        entry.minimum,
        entry.maximum,
        entry.default,
        "rw" if access & ObjectAccess.WRITE else "ro",
        "PreOP" if preop else None,
        mappable or None,
        "1" if access & ObjectAccess.BACKUP else None,
    )


def test_each_entry_of_a_drive_is_described_as_in_its_dictionary(servo: Element) -> None:
    kinds = {text(each, "Name"): each for each in servo.iter("DataType") if len(each)}
    elements = servo.findall("Profile/Dictionary/Objects/Object")
    for element, each in zip(elements, Drive().objects(), strict=True):
        assert (hexadecimal(text(element, "Index")), text(element, "Name")) == (
            each.index,
            each.name,
        )
        info = element.find("Info")
        assert info is not None
        kind = kinds[text(element, "Type")]
        assert text(element, "BitSize") == text(kind, "BitSize")
        if not kind.findall("SubItem"):
            assert NAMES[text(element, "Type")] == each.data_type
            assert described(info, element.find("Flags")) == expected(each.entries[0])
            continue
        items = zip(kind.findall("SubItem"), info.findall("SubItem"), each.entries, strict=True)
        for item, values, entry in items:
            assert text(item, "Name") == text(values, "Name") == entry.name
            assert int(text(item, "SubIdx")) == entry.subindex
            assert NAMES[text(item, "Type")] == DataType(entry.data_type)
            match = values.find("Info")
            assert match is not None
            assert described(match, item.find("Flags")) == expected(entry)


def test_each_mapped_entry_of_a_drive_is_in_its_dictionary(servo: Element) -> None:
    known = {
        (each.index, entry.subindex): entry for each in Drive().objects() for entry in each.entries
    }
    for tag, bit, assigned in (
        ("RxPdo", ObjectAccess.RX_PDO, [("1600", "2")]),
        ("TxPdo", ObjectAccess.TX_PDO, [("1A00", "3")]),
    ):
        pdos = servo.findall(tag)
        results = [
            (text(each, "Index")[2:], each.get("Sm")) for each in pdos if "Sm" in each.attrib
        ]
        assert results == assigned
        for pdo in pdos:
            others = {text(each, "Index") for each in pdos if each is not pdo}
            assert {each.text for each in pdo.findall("Exclude")} == others
            for each in pdo.findall("Entry"):
                entry = known[hexadecimal(text(each, "Index")), int(text(each, "SubIndex"))]
                assert entry.access & bit
                assert int(text(each, "BitLen")) == entry.bits
                assert NAMES[text(each, "DataType")] == entry.data_type
