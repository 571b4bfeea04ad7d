"""The register map as a table."""

from itertools import pairwise

from achse.ethercat.registers import FMMU_BASE, RAM_BASE, SM_BASE, Register


def test_registers_ascend_and_do_not_overlap() -> None:
    for one, other in pairwise(Register):
        assert one.end <= other, (one, other)
    assert max(Register).end <= RAM_BASE


def test_channels_have_their_room() -> None:
    for row in Register:
        for base, size in ((FMMU_BASE, 0x100), (SM_BASE, 0x80)):
            assert row.end <= base or row >= base + size, row


def test_defaults_fit() -> None:
    assert all(0 <= row.default < 1 << 8 * row.size for row in Register)


def test_each_register_has_a_title_of_its_own() -> None:
    assert len({row.title for row in Register}) == len(Register) == 61


def test_values_are_little_endian() -> None:
    memory = bytearray(0x1000)
    Register.AL_STATUS_CODE.set(memory, 0x0011)
    assert memory[Register.AL_STATUS_CODE.place] == b"\x11\x00"
    assert Register.AL_STATUS_CODE.get(memory) == 0x11
    assert Register.AL_STATUS_CODE == 0x0134
