"""Outputs of a program: fast M functions are bits, a handshake is a level."""

from achse.gcode.canon import Technology
from achse.motion.channels.technology import HandshakeStep, TechnologyOutputs


def test_bits_of_fast_m_functions() -> None:
    out = TechnologyOutputs()
    for number in (0, 31, 32, 159):
        out.set_fast(number)
        assert out.is_fast(number)
    assert out.fast == [0x8000_0001, 1, 0, 0, 0x8000_0000]
    out.clear_fast((0, 159))
    assert out.fast == [0x8000_0000, 1, 0, 0, 0]


def test_a_handshake_begins_and_ends_with_a_level() -> None:
    out = TechnologyOutputs()
    assert not out.handshake(40, 1)
    assert (out.request, out.step) == (0, HandshakeStep.BEFORE)
    assert not out.handshake(40, 0)
    assert (out.request, out.number) == (1, 40)
    assert not out.handshake(40, 0)
    assert out.handshake(40, 1)
    assert out.request == 0
    out.handshake(41, 0)
    out.drop()
    assert (out.request, out.step) == (0, HandshakeStep.NONE)


def test_words() -> None:
    out = TechnologyOutputs()
    out.show(Technology.AUXILIARY, -7.9)
    out.show(Technology.SPINDLE, 70_000.0)
    out.show(Technology.TOOL, 5.0)
    assert (out.auxiliary, out.spindle, out.tool) == (-7, 70_000 & 0xFFFF, 5)
    out.clear()
    assert (out.auxiliary, out.spindle, out.tool) == (0, 0, 0)
