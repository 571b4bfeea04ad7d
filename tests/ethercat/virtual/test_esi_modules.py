"""Modules in slots: PDOs and objects at the place of the slot, F030h and F050h."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat.master.esi_reader import EsiDevice, EsiError, read_esi
from achse.ethercat.virtual import make_slave
from achse.ethercat.virtual.esi_modules import equip, module_names
from tests.ethercat.virtual.esi_text import COE, INPUTS, MAILBOX, OUTPUTS, device, esi, pdo
from tests.ethercat.virtual.test_slaves import bus_of


def module(name: str, ident: int, *pdos: str) -> str:
    text = "".join(pdos).replace("<Index>#x", '<Index DependOnSlot="1">#x')
    return (
        f'<Module><Type ModuleIdent="#x{ident:08X}">{name}</Type><Name>{name}</Name>{text}</Module>'
    )


IN = module("IN", 0x11, pdo("TxPdo", 0x1A00, [(0x6000, 1, 8, "Bits", "USINT")], Sm=3))
OUT = module("OUT", 0x22, pdo("RxPdo", 0x1600, [(0x7000, 1, 16, "Value", "INT")], Sm=2))
SLOTS = (
    '<Slots SlotPdoIncrement="1" SlotIndexIncrement="#x10"><Slot MaxInstances="8">'
    '<ModuleIdent Default="1">#x22</ModuleIdent><ModuleIdent>#x11</ModuleIdent></Slot></Slots>'
)


def coupler(slots: str = SLOTS) -> EsiDevice:
    body = MAILBOX + OUTPUTS + INPUTS + COE + "</Mailbox>" + slots
    return read_esi(esi(device(body), modules=IN + OUT))[0]


@given(names=st.lists(st.sampled_from(["IN", "OUT"]), min_size=1, max_size=8))
def test_each_module_is_at_its_slot(names: list[str]) -> None:
    slave = make_slave(coupler(), modules=names)
    result = slave.device
    assert result.input_size == names.count("IN")
    assert result.output_size == 2 * names.count("OUT")
    for place, name in enumerate(names):
        index = (0x6000 if name == "IN" else 0x7000) + 0x10 * place
        assert result.channels[f"{index:04X}:01"].output == (name == "OUT")
        for listed in (0xF030, 0xF050):
            ident = int.from_bytes(result.read_object(listed, place + 1), "little")
            assert ident == (0x11 if name == "IN" else 0x22)
    bus_of(slave).up()
    assert slave.state is AlState.OP


def test_start_commands_of_modules_are_at_their_slots() -> None:
    commands = (
        '<Mailbox><CoE><InitCmd><Transition>PS</Transition><Index DependOnSlot="1">#x8000</Index>'
        "<SubIndex>1</SubIndex><Data>05</Data></InitCmd></CoE><SoE><InitCmd Chn="
        '"1"><Transition>PS</Transition><IDN>32</IDN><Data>0b00</Data></InitCmd></SoE></Mailbox>'
    )
    body = MAILBOX + OUTPUTS + INPUTS + COE + '<SoE ChannelCount="2"/></Mailbox>' + SLOTS
    modules = IN.replace("</Module>", commands + "</Module>") + OUT
    box = read_esi(esi(device(body), modules=modules))[0]
    slave = make_slave(box, modules=["OUT", "IN", "IN"])
    result = slave.device
    assert [each.index for each in result.esi.commands] == [0x8010, 0x8020]
    bus_of(slave).up()
    assert slave.state is AlState.OP
    assert [result.read_object(index, 1) for index in (0x8010, 0x8020)] == [b"\5", b"\5"]
    assert result.messages.parameters is not None
    assert result.messages.parameters.value(32, 1) == b"\x0b\0"


def test_slots_have_their_default_modules() -> None:
    assert equip(coupler()).idents == (0x22,)
    assert module_names(coupler()) == ["IN", "OUT"]
    assert equip(coupler("")).idents is None


@pytest.mark.parametrize(
    ("slots", "names", "message"),
    [
        ("", ["IN"], "has no slots"),
        (SLOTS, ["XX"], "no module 'XX'; there are: IN, OUT"),
        (SLOTS.replace('"1" Slot', '"x" Slot'), ["IN"], "SlotPdoIncrement"),
        (SLOTS, ["IN"] * 256, "255 modules at most"),
        (SLOTS.replace("#x10", "#xFFFF"), ["IN", "IN"], "Entry/Index: expected 1 to 0xFFFF"),
    ],
)
def test_modules_that_cannot_be_are_reported(slots: str, names: list[str], message: str) -> None:
    with pytest.raises(EsiError, match=message):
        equip(coupler(slots), names)
