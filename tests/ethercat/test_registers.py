"""The register map as a table."""

from itertools import pairwise

from achse.ethercat.registers import FMMU_BASE, RAM_BASE, REGISTERS, SM_BASE


def test_registers_ascend_and_do_not_overlap() -> None:
    for one, other in pairwise(REGISTERS):
        assert one.address + one.size <= other.address, (one, other)
    assert REGISTERS[-1].address + REGISTERS[-1].size <= RAM_BASE


def test_channels_have_their_room() -> None:
    for row in REGISTERS:
        for base, size in ((FMMU_BASE, 0x100), (SM_BASE, 0x80)):
            assert row.address + row.size <= base or row.address >= base + size, row


def test_defaults_fit() -> None:
    assert all(0 <= row.default < 1 << 8 * row.size for row in REGISTERS)


def test_each_register_has_a_name_of_its_own() -> None:
    assert len({row.name for row in REGISTERS}) == len(REGISTERS)
