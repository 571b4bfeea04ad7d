"""ESI files: ours are read as what they were made from, those of vendors, any text at all."""

import contextlib
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.drive import Drive
from achse.ethercat import Loopback, describe
from achse.ethercat.esi import build_esi
from achse.ethercat.master import (
    BusConfiguration,
    ClockConfiguration,
    InitCommand,
    Master,
    Ring,
    from_description,
)
from achse.ethercat.master.configuration import IdnCommand
from achse.ethercat.master.esi_reader import (
    EsiError,
    EsiMode,
    EsiTime,
    described,
    from_esi,
    read_esi,
)

SERVO = """<?xml version="1.0" encoding="ISO-8859-1"?>
<EtherCATInfo><Vendor><Id>#x0000BEEF</Id><Name>Maker</Name></Vendor><Descriptions><Devices>
<Device Physics="YY">
 <Type ProductCode="#x1234" RevisionNo="#x00010002">Servo-7</Type>
 <Name LcId="1031"><![CDATA[Servo (deutsch)]]></Name><Name LcId="1033"><![CDATA[Servo 7]]></Name>
 <Info><StateMachine><Timeout><PreopTimeout>2000</PreopTimeout>
  <SafeopOpTimeout>9000</SafeopOpTimeout></Timeout></StateMachine>
  <Mailbox><Timeout><RequestTimeout>50</RequestTimeout><ResponseTimeout>1500</ResponseTimeout>
  </Timeout></Mailbox></Info>
 <GroupType>Drives</GroupType>
 <Fmmu>Outputs</Fmmu><Fmmu>Inputs</Fmmu><Fmmu>MBoxState</Fmmu>
 <Sm DefaultSize="128" StartAddress="#x1800" ControlByte="#x26" Enable="1">MBoxOut</Sm>
 <Sm DefaultSize="128" StartAddress="#x1880" ControlByte="#x22" Enable="1">MBoxIn</Sm>
 <Sm DefaultSize="6" StartAddress="#x1100" ControlByte="#x64" Enable="1">Outputs</Sm>
 <Sm DefaultSize="6" StartAddress="#x1140" ControlByte="#x20" Enable="1" OpOnly="1"/>
 <RxPdo Sm="2" Fixed="1"><Index>#x1600</Index><Exclude>#x1601</Exclude><Name>csp</Name>
  <Entry><Index>#x6040</Index><SubIndex>0</SubIndex><BitLen>16</BitLen><Name>Control</Name>
   <DataType>UINT</DataType></Entry>
  <Entry><Index>#x607A</Index><BitLen>32</BitLen><DataType>DINT</DataType></Entry></RxPdo>
 <RxPdo><Index>#x1601</Index><Exclude>#x1600</Exclude><Name>csv</Name>
  <Entry><Index>#x6040</Index><BitLen>16</BitLen></Entry>
  <Entry><Index>0</Index><BitLen>8</BitLen></Entry></RxPdo>
 <TxPdo Sm="3" Mandatory="true"><Index>#x1A00</Index><Name>actual</Name>
  <Entry><Index>#x6041</Index><BitLen>16</BitLen><DataType>UINT</DataType></Entry></TxPdo>
 <TxPdo><Index>#x1A01</Index><Name>more</Name>
  <Entry><Index>#x60F4</Index><BitLen>32</BitLen></Entry></TxPdo>
 <Mailbox DataLinkLayer="true"><CoE SdoInfo="1" PdoAssign="1" CompleteAccess="1">
   <InitCmd><Transition>PS</Transition><Transition>SO</Transition><Index>#x6060</Index>
    <SubIndex>0</SubIndex><Data>08</Data><Comment>csp</Comment></InitCmd></CoE><FoE/></Mailbox>
 <Dc><OpMode><Name>DC</Name><AssignActivate>#x300</AssignActivate>
   <CycleTimeSync0 Factor="1">0</CycleTimeSync0><ShiftTimeSync0>20000</ShiftTimeSync0></OpMode>
  <OpMode><Name>Free</Name><AssignActivate>#x0</AssignActivate></OpMode>
  <OpMode><Name>Csv</Name><Desc>velocity</Desc><AssignActivate>#x700</AssignActivate>
   <CycleTimeSync0 Factor="-4">0</CycleTimeSync0><CycleTimeSync1 Factor="2"/>
   <ShiftTimeSync1>100</ShiftTimeSync1><Sm No="2"><Pdo>#x1601</Pdo></Sm></OpMode></Dc>
 <Eeprom><ByteSize>2048</ByteSize><ConfigData>080CEE88</ConfigData></Eeprom>
</Device>
<Device><Type ProductCode="2">Terminal</Type><Sm StartAddress="#xF00" ControlByte="#x44"/>
 <RxPdo Sm="0"><Index>#x1600</Index><Entry><Index>#x7000</Index><SubIndex>1</SubIndex>
 <BitLen>1</BitLen><DataType>BOOL</DataType></Entry></RxPdo></Device>
<Device><Name>a group head without a type</Name></Device>
</Devices></Descriptions></EtherCATInfo>
"""


@pytest.mark.parametrize("application", [Drive, Loopback])
def test_what_we_write_is_the_same_configuration(application: Callable[[], Any]) -> None:
    description = describe(application())
    (device,) = read_esi(build_esi(description, vendor="nobody"))
    result = from_esi(device)
    wanted = from_description(description)
    for name in (
        *("vendor_id", "product_code", "revision_number", "mailbox_out", "mailbox_in", "coe"),
        *("sync_managers", "times", "type_name", "name"),
    ):
        assert getattr(result, name) == getattr(wanted, name), name
    for ours, theirs in ((result.outputs, wanted.outputs), (result.inputs, wanted.inputs)):
        assert [replace(each, entries=()) for each in ours] == [
            replace(each, entries=()) for each in theirs
        ]
        assert [(e.index, e.subindex, e.bits) for p in ours for e in p.entries] == [
            (e.index, e.subindex, e.bits) for p in theirs for e in p.entries
        ]
    assert from_esi(device, mode="DC").clock == ClockConfiguration(0x300, 2_000_000)
    assert from_esi(device, mode="FreeRun").clock is None


def test_a_slave_comes_up_by_its_esi(bus: Callable[..., Any]) -> None:
    from achse.ethercat import Segment, Slave

    line = [Drive(), Drive()]
    (device,) = read_esi(build_esi(describe(line[0]), vendor="nobody"))
    slaves = tuple(from_esi(device, f"Box {n}", mode="DC", cycle_ns=1_000_000) for n in (1, 2))
    ours = bus()
    ours.master = Master(BusConfiguration(slaves, cycle_ns=1_000_000))
    ours.segment = Segment(map(Slave, line))
    ours.ring = Ring(ours.master, ours.segment)
    ours.up()
    status = ours.master.slaves[1].read_input(0x6041)
    assert status & 0x0200


def test_a_servo_of_a_vendor() -> None:
    servo, terminal = read_esi(SERVO)
    assert (servo.name, servo.type_name, servo.group) == ("Servo 7", "Servo-7", "Drives")
    assert (servo.vendor_id, servo.product_code, servo.revision_number) == (0xBEEF, 0x1234, 0x10002)
    assert (servo.protocols, servo.mailbox_repeat) == ({"CoE", "FoE"}, True)
    assert [each.use for each in servo.sync_managers] == ["MBoxOut", "MBoxIn", "Outputs", "Inputs"]
    assert [each.op_only for each in servo.sync_managers] == [False, False, False, True]
    assert servo.times.preop_ns == 2_000_000_000
    assert servo.times.back_to_safeop_ns == 200_000_000
    assert (servo.times.request_ns, servo.times.response_ns) == (50_000_000, 1_500_000_000)
    assert (servo.eeprom_size, servo.eeprom_head) == (2048, bytes.fromhex("080CEE88"))
    result = from_esi(servo, cycle_ns=4_000_000)
    assert [each.index for each in (*result.outputs, *result.inputs)] == [0x1600, 0x1A00]
    assert result.clock == ClockConfiguration(0x300, 4_000_000, 0, 2_020_000)
    assert (result.assign, result.configure, result.complete_access) == (True, False, True)
    assert result.commands == (
        InitCommand(0x6060, 0, b"\x08", "PS", comment="csp"),
        InitCommand(0x6060, 0, b"\x08", "SO", comment="csp"),
    )
    plain = from_esi(terminal)
    assert (plain.coe, plain.mailbox_out, plain.name) == (False, None, "Terminal")
    assert plain.bits(plain.sync_managers[0]) == 1


def test_modes_bring_their_pdos_and_times() -> None:
    servo = read_esi(SERVO)[0]
    result = from_esi(servo, mode="Csv", cycle_ns=4_000_000)
    assert [each.index for each in (*result.outputs, *result.inputs)] == [0x1601, 0x1A00]
    assert result.outputs[0].sync_manager == 2
    # SYNC0 four times in a cycle; SYNC1 with every second of them
    assert result.clock == ClockConfiguration(0x700, 1_000_000, 1_000_100)
    assert from_esi(servo, mode="Free").clock is None
    with pytest.raises(EsiError, match="no mode 'sine'; there are: DC, Free, Csv"):
        from_esi(servo, mode="sine")


@pytest.mark.parametrize(
    ("pdos", "message"),
    [
        ([0x1600, 0x1601, 0x1A00], "1600 excludes 1601"),
        ([0x1600], "1A00 is mandatory"),
        ([0x1600, 0x1A00, 0x1B00], "no PDO 1B00"),
    ],
)
def test_pdos_that_cannot_be(pdos: list[int], message: str) -> None:
    with pytest.raises(EsiError, match=message):
        from_esi(read_esi(SERVO)[0], pdos=pdos)


def test_of_default_pdos_that_exclude_each_other_the_first_is_taken() -> None:
    """Terminals with several packings of a value assign all of them, in files of their maker."""
    both = SERVO.replace("<RxPdo><Index>#x1601", '<RxPdo Sm="2"><Index>#x1601')
    assert [each.index for each in from_esi(read_esi(both)[0]).outputs] == [0x1600]
    assert [each.index for each in from_esi(read_esi(both)[0], mode="Csv").outputs] == [0x1601]
    strict = both.replace(
        '<RxPdo Sm="2"><Index>#x1601', '<RxPdo Sm="2" Mandatory="1"><Index>#x1601'
    )
    with pytest.raises(EsiError, match="1600 excludes 1601"):
        from_esi(read_esi(strict)[0])


def test_pdos_may_be_chosen() -> None:
    result = from_esi(read_esi(SERVO)[0], pdos=[0x1601, 0x1A00, 0x1A01])
    assert [(each.index, each.sync_manager) for each in (*result.outputs, *result.inputs)] == [
        *((0x1601, 2), (0x1A00, 3), (0x1A01, 3))
    ]


def test_one_device_of_many() -> None:
    assert [each.type_name for each in read_esi(SERVO, product_code=2)] == ["Terminal"]
    assert [each.type_name for each in read_esi(SERVO, revision_number=0x10002)] == ["Servo-7"]
    assert read_esi(SERVO, product_code=3) == []
    broken = SERVO.replace("<BitLen>1</BitLen>", "<BitLen>one</BitLen>")
    assert len(read_esi(broken, product_code=0x1234)) == 1


def soe(inner: str, drive: str = "0") -> str:
    """The servo with a start command of SoE."""
    command = f'<InitCmd Chn="{drive}"><Transition>PS</Transition>{inner}</InitCmd>'
    return SERVO.replace("<CoE", f"<SoE>{command}</SoE><CoE", 1)


@pytest.mark.parametrize(
    "clock", [(0x10000, 0, 0, None), (1, 1 << 32, 0, None), (1, 0, -1, None), (1, 0, 0, -(1 << 32))]
)
def test_clocks_have_32_bits(clock: tuple[int, int, int, int | None]) -> None:
    with pytest.raises(ValueError, match="expected 0 to"):
        ClockConfiguration(*clock)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not XML"),
        ("<a/>", "the root is a"),
        ("<!DOCTYPE x><x/>", "DOCTYPE"),
        (SERVO.replace("#x0000BEEF", "beef"), "Vendor/Id: expected a number"),
        (SERVO.replace("#x0000BEEF", "-1"), "Vendor Id: expected 0 to 0xFFFFFFFF, got -1"),
        (SERVO.replace("#x1234", "#x100000000"), "ProductCode: expected 0 to 0xFFFFFFFF"),
        (SERVO.replace("#x00010002", "4294967296"), "RevisionNo: expected 0 to 0xFFFFFFFF"),
        (SERVO.replace('ControlByte="#x26"', 'ControlByte="#x126"'), "Sm ControlByte"),
        (SERVO.replace('RxPdo Sm="2"', 'RxPdo Sm="99"'), "PDO Sm: expected 0 to 0xF"),
        (SERVO.replace("<Data>08", "<Data>0z"), "Servo-7: "),
        (SERVO.replace("<Sm ", "<Sm></Sm>" * 16 + "<Sm ", 1), "Sm: expected at most 16, got 2"),
        (SERVO.replace("<Fmmu>", "<Fmmu/>" * 16 + "<Fmmu>", 1), "Fmmu: expected at most 16"),
        (soe("<IDN>65536</IDN><Data/>"), "SoE InitCmd IDN: expected 0 to 0xFFFF"),
        (soe("<IDN>1</IDN><Data/>", "8"), "Chn: expected 0 to 0x7, got 8"),
        (soe("<IDN>1</IDN><Data>0g</Data>"), "Servo-7: "),
    ],
)
def test_other_files_are_refused(text: str, message: str) -> None:
    with pytest.raises(EsiError, match=message):
        read_esi(text)


@given(
    at=st.integers(0, len(SERVO)),
    junk=st.text(max_size=8),
    cut=st.integers(0, 60),
    mode=st.sampled_from(["", "DC", "Csv"]),
    cycle_ns=st.integers(1, 10**9),
    pdos=st.none() | st.sets(st.sampled_from([0x1600, 0x1601, 0x1A00, 0x1A01])),
)
def test_changed_files_are_read_or_refused(
    at: int, junk: str, cut: int, mode: str, cycle_ns: int, pdos: set[int] | None
) -> None:
    with contextlib.suppress(EsiError):
        for device in read_esi(SERVO[:at] + junk + SERVO[at + cut :]):
            from_esi(device, mode=mode, cycle_ns=cycle_ns, pdos=pdos)


@given(
    cycle_ns=st.integers(1, 10**9),
    factor0=st.integers(-20, 20),
    factor1=st.integers(-20, 20),
    shift0=st.integers(-(10**6), 10**6),
    shift1=st.integers(0, 10**6),
    activate=st.sampled_from([0, 0x300, 0x700]),
)
def test_times_of_modes(
    cycle_ns: int, factor0: int, factor1: int, shift0: int, shift1: int, activate: int
) -> None:
    mode = EsiMode("m", activate, EsiTime(0, factor0), EsiTime(0, factor1), shift0, shift1)
    try:
        clock = mode.clock(cycle_ns)
    except EsiError:  # the registers of a clock have 32 bits
        assert cycle_ns * max(factor0, factor0 * factor1, factor1, 1) + shift1 >= 1 << 32
        return
    if not activate:
        assert clock is None
        return
    assert clock is not None
    wanted = cycle_ns * factor0 if factor0 > 0 else cycle_ns // -factor0 if factor0 else 0
    assert clock.cycle0_ns == wanted
    assert clock.cycle1_ns >= shift1
    assert (clock.shift_ns is None) == (shift0 == 0)


def test_a_scanned_slave_gets_what_its_esi_reports() -> None:
    servo = read_esi(SERVO)[0]
    result = replace(from_esi(servo), clock=None, commands=(), revision_number=0x20000)
    older = replace(servo, revision_number=1, type_name="old")
    newer = replace(servo, revision_number=0x30000, type_name="new")
    instance = described(result, [older, servo, newer], cycle_ns=1_000_000)
    assert (instance.type_name, instance.times) == ("Servo-7", servo.times)
    assert instance.clock == ClockConfiguration(0x300, 1_000_000, 0, 520_000)
    assert instance.commands == servo.commands
    with_idns = replace(servo, idn_commands=(IdnCommand(32, b"\x0b\0"),))
    assert described(result, [with_idns]).idn_commands == with_idns.idn_commands
    assert described(result, [newer]) is result
