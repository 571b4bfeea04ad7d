"""The device: objects of the file, values by SDO and by name, emergencies, files."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import AbortCode, AlState, AlStatus, FileRefusal, FoeError, SdoAbort
from achse.ethercat.application import FileApplication, ObjectAccess
from achse.ethercat.master.esi_reader import EsiError, read_esi
from achse.ethercat.virtual import VirtualDevice, make_slave
from achse.ethercat.virtual.device import VirtualFileDevice
from tests.ethercat.virtual.esi_text import ANALOG, VENDOR, device, esi, pdo

DICTIONARY = """<Profile><Dictionary><DataTypes/><Objects>
<Object><Index>#x2000</Index><Name>Limit</Name><Type>INT</Type><BitSize>16</BitSize>
 <Info><MinValue>-10</MinValue><MaxValue>10</MaxValue><DefaultValue>3</DefaultValue></Info>
 <Flags><Access>rw</Access></Flags></Object>
<Object><Index>#x2001</Index><Name>Key</Name><Type>UDINT</Type><BitSize>32</BitSize>
 <Flags><Access>wo</Access></Flags></Object>
<Object><Index>#x2002</Index><Name>Note</Name><Type>STRING(5)</Type><BitSize>40</BitSize>
 <Flags><Access WriteRestrictions="PreOP">rw</Access></Flags></Object>
</Objects></Dictionary></Profile>"""


def preop_device(text: str = ANALOG) -> VirtualDevice:
    result = make_slave(read_esi(esi(text))[0], serial_number=77).device
    result.enter(AlState.PREOP, 0, AlStatus.NO_ERROR)
    return result


def code(device: VirtualDevice, index: int, data: bytes | None = None) -> AbortCode | None:
    try:
        if data is None:
            device.read_object(index, 0)
        else:
            device.write_object(index, 0, data)
    except SdoAbort as abort:
        return abort.code
    return None


@given(value=st.integers(-0x8000, 0x7FFF))
def test_value_by_sdo_keeps_its_limits(value: int) -> None:
    device_ = preop_device(device(DICTIONARY))
    assert device_.read_object(0x2000, 0) == b"\x03\0"
    data = value.to_bytes(2, "little", signed=True)
    expected = AbortCode.TOO_LOW if value < -10 else AbortCode.TOO_HIGH if value > 10 else None
    assert code(device_, 0x2000, data) is expected
    assert device_.read_object(0x2000, 0) == (b"\x03\0" if expected else data)


def test_access_is_that_of_the_file() -> None:
    device_ = preop_device(device(DICTIONARY))
    assert code(device_, 0x2000, b"\1") is AbortCode.LENGTH
    assert code(device_, 0x2001) is AbortCode.WRITE_ONLY
    assert code(device_, 0x1000, bytes(4)) is AbortCode.READ_ONLY
    assert code(device_, 0x2002, b"123456") is AbortCode.TOO_LONG
    assert code(device_, 0x2002, b"123") is None
    assert device_.read_object(0x2002, 0) == b"123"
    assert code(device_, 0x3000) is AbortCode.NO_OBJECT
    device_.enter(AlState.OP, 0, AlStatus.NO_ERROR)
    assert code(device_, 0x2002, b"1") is AbortCode.DEVICE_STATE


def test_device_has_the_usual_objects_and_those_of_its_pdos() -> None:
    device_ = preop_device()
    identity = [int.from_bytes(device_.read_object(0x1018, n), "little") for n in range(1, 5)]
    assert identity == [VENDOR, 0x3001, 0x10000, 77]
    assert device_.read_object(0x1008, 0) == b"AIO"
    assert [device_.read_object(0x1C00, n)[0] for n in range(1, 5)] == [1, 2, 3, 4]
    by_index = {each.index: each for each in device_.objects()}
    assert by_index[0x7000].entries[1].access & ObjectAccess.RX_PDO
    assert by_index[0x6000].entries[-1].access & ObjectAccess.TX_PDO
    assert [each.index for each in device_.objects()] == sorted(by_index)


def test_process_data_are_objects_too() -> None:
    device_ = preop_device()
    device_.set_input("Value", -2)
    assert device_.read_object(0x6000, 2) == b"\xfe\xff"
    device_.write_outputs(b"\x11\x22")
    assert device_.read_object(0x7000, 1) == b"\x11\x22"
    assert device_.output("Valve") == 0x2211
    assert device_.read_inputs() == b"\0\0\xfe\xff"


def test_wrong_names_are_reported() -> None:
    device_ = preop_device()
    with pytest.raises(KeyError, match="there are: Valve"):
        device_.output("Vlave")
    with pytest.raises(ValueError, match="is an output"):
        device_.set_input("Valve", 1)
    objects = "<Object><Index>0</Index></Object>"
    dictionary = f"<Profile><Dictionary><Objects>{objects}</Objects></Dictionary></Profile>"
    with pytest.raises(EsiError, match="Box: Object Index: expected 1 to 0xFFFF, got 0"):
        preop_device(device(dictionary))


def test_emergencies_wait_for_the_master() -> None:
    device_ = preop_device()
    device_.emergencies += [b"1" * 8, b"2" * 8]
    assert [device_.take_emergency() for _ in range(3)] == [b"1" * 8, b"2" * 8, None]


def test_files_are_kept_where_the_mailbox_has_foe() -> None:
    device_ = preop_device()
    assert isinstance(device_, FileApplication)
    device_.begin_file("a.bin", 0)
    device_.write_file("a.bin", b"content")
    assert device_.read_file("a.bin", 0) == b"content"
    with pytest.raises(FileRefusal, match=f"{FoeError.NOT_FOUND:04X}"):
        device_.read_file("b.bin", 0)
    assert not isinstance(preop_device(device(pdo("RxPdo", 0x1600, []))), FileApplication)


def test_files_have_room_together() -> None:
    device_ = preop_device()
    assert isinstance(device_, VirtualFileDevice)
    half = bytes(1 << 24)
    for name in ("a", "b", "a"):
        device_.write_file(name, half)
    with pytest.raises(FileRefusal, match=f"{FoeError.DISK_FULL:04X}"):
        device_.write_file("c", b"x")
    assert sorted(device_.files) == ["a", "b"]
