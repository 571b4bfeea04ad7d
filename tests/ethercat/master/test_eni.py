"""ENI files: what is written is read, files of configurators are read, others are refused."""

import contextlib
import dataclasses
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.drive import Drive
from achse.ethercat import describe
from achse.ethercat.master import BusConfiguration, ClockConfiguration, InitCommand
from achse.ethercat.master.configuration import IdnCommand, from_description
from achse.ethercat.master.eni import EniError, read_eni, write_eni

FOREIGN = """<?xml version="1.0"?>
<EtherCATConfig><Config>
 <Master><Info><Name><![CDATA[Device 2 (EtherCAT)]]></Name></Info></Master>
 <Slave>
  <Info><Name><![CDATA[Drive 3]]></Name><PhysAddr>1003</PhysAddr><AutoIncAddr>0</AutoIncAddr>
   <VendorId>2</VendorId><ProductCode>#x1a2b</ProductCode><RevisionNo>1114112</RevisionNo></Info>
  <ProcessData>
   <Sm2><Type>Outputs</Type><StartAddress>4352</StartAddress><ControlByte>36</ControlByte>
    <Pdo>5632</Pdo></Sm2>
   <Sm3><Type>Inputs</Type><StartAddress>4480</StartAddress><ControlByte>34</ControlByte></Sm3>
   <TxPdo Fixed="1" Sm="3"><Index>#x1a00</Index><Name>In</Name>
    <Entry><Index>#x6041</Index><SubIndex>0</SubIndex><BitLen>16</BitLen><Name>Status</Name>
     <DataType>UINT</DataType></Entry></TxPdo>
   <TxPdo><Index>#x1a01</Index><Name>not assigned</Name></TxPdo>
   <RxPdo Sm="2"><Index>#x1600</Index><Name>Out</Name>
    <Entry><Index>#x6040</Index><SubIndex>0</SubIndex><BitLen>16</BitLen></Entry>
    <Entry><Index>#x0</Index><BitLen>8</BitLen></Entry></RxPdo>
  </ProcessData>
  <Mailbox><Send><Start>4096</Start><Length>128</Length></Send>
   <Recv><Start>4224</Start><Length>128</Length></Recv><Protocol>CoE</Protocol>
   <CoE><InitCmds><InitCmd CompleteAccess="1"><Transition>PS</Transition><Ccs>1</Ccs>
     <Index>24640</Index><SubIndex>0</SubIndex><Data>0800</Data></InitCmd>
    <InitCmd><Transition>IP</Transition><Ccs>2</Ccs><Index>1</Index></InitCmd></InitCmds></CoE>
  </Mailbox>
  <DC><CycleTime0>2000000</CycleTime0><ShiftTime>30000</ShiftTime></DC>
 </Slave>
 <Cyclic><CycleTime>2000</CycleTime></Cyclic>
</Config></EtherCATConfig>
"""


def test_a_file_of_a_configurator() -> None:
    bus = read_eni(FOREIGN)
    assert (bus.name, bus.cycle_ns) == ("Device 2 (EtherCAT)", 2_000_000)
    (slave,) = bus.slaves
    assert (slave.name, slave.station, slave.product_code) == ("Drive 3", 1003, 0x1A2B)
    assert [each.bits for each in slave.outputs[0].entries] == [16, 8]
    assert [each.name for each in slave.inputs[0].entries] == ["Status"]
    assert [each.output for each in slave.sync_managers] == [True, False]
    assert slave.mailbox_in is not None
    assert slave.mailbox_in.length == 128
    assert slave.commands == (InitCommand(0x6040, 0, b"\x08\x00", "PS", True, ""),)
    assert slave.clock == ClockConfiguration(0x0300, 2_000_000, 0, 30_000)


def test_what_is_written_is_read() -> None:
    slave = from_description(
        describe(Drive()), "Drive <1> & co", clock=ClockConfiguration(cycle0_ns=500, shift_ns=7)
    )
    slave = dataclasses.replace(
        slave.with_entries([(0x6040, 0, 16), (0, 0, 8)], [(0x6041, 0, 16)]),
        commands=(InitCommand(0x6060, 0, b"\x08", comment="mode"),),
        idn_commands=(IdnCommand(32, b"\x0b\0", 1, "SO"), IdnCommand(1, b"\0\0", adapts=True)),
    )
    bus = BusConfiguration((slave, dataclasses.replace(slave, optional=True)), cycle_ns=4_000_000)
    again = read_eni(write_eni(bus))
    assert again.cycle_ns == bus.cycle_ns
    first, second = again.slaves
    assert (first.station, second.station, second.optional) == (1001, 1002, True)
    for field in ("name", "outputs", "inputs", "sync_managers", "mailbox_out", "clock", "commands"):
        assert getattr(first, field) == getattr(slave, field), field
    assert first.idn_commands == (
        IdnCommand(32, b"\x0b\0", 1, "SO"),
        IdnCommand(1, (4000).to_bytes(2, "little")),  # as the bus is
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not XML"),
        ("<a/>", "the root is a"),
        ("<!DOCTYPE x [<!ENTITY a 'b'>]><x/>", "a DOCTYPE is not accepted"),
        (FOREIGN.replace("<PhysAddr>1003", "<PhysAddr>ten"), "Info/PhysAddr: expected a number"),
        (FOREIGN.replace("<Data>0800", "<Data>08zz"), "Slave 1"),
        (FOREIGN.replace('Sm="2"', 'Sm="two"'), "Slave 1"),
    ],
)
def test_other_files_are_refused(text: str, message: str) -> None:
    with pytest.raises(EniError, match=message):
        read_eni(text)


@given(at=st.integers(0, len(FOREIGN)), junk=st.text(max_size=8), cut=st.integers(0, 60))
def test_changed_files_are_read_or_refused(at: int, junk: str, cut: int) -> None:
    with contextlib.suppress(EniError):
        read_eni(FOREIGN[:at] + junk + FOREIGN[at + cut :])


def test_a_scan_is_written(bus: Callable[..., Any]) -> None:
    text = write_eni(bus(2).master.bus)
    assert [each.name for each in read_eni(text.encode()).slaves] == ["Box 1", "Box 2"]
