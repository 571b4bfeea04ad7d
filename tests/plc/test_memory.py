"""Memory areas, direct addresses and resets."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.plc.memory import SPARSE, Area, AreaFullError, Memory, MemoryRangeError, Region


@given(st.lists(st.tuples(st.integers(1, 40), st.sampled_from([1, 2, 4, 8])), max_size=30))
def test_allocations_are_aligned_and_never_overlap(wishes: list[tuple[int, int]]) -> None:
    region = Region(Area.DATA, 0)
    end = 0
    for size, alignment in wishes:
        offset = region.allocate(size, alignment)
        assert offset % alignment == 0
        assert end <= offset < end + alignment
        end = offset + size
    assert (
        not wishes or len(region) >= end + 1024
    )  # a STRING read by its address asks for 1024 bytes


def test_fixed_addresses_may_overlap_and_others_are_placed_behind_them() -> None:
    region = Memory()[Area.FLAG]
    region.place(4, 4)
    region.place(6, 1)
    assert region.allocate(2, 2) == 8


def test_the_process_image_does_not_grow() -> None:
    region = Memory({Area.INPUT: 8})[Area.INPUT]
    region.place(0, 8)
    with pytest.raises(AreaFullError, match=r"%I has 8 bytes, bytes 7\.\.8 do not fit"):
        region.place(7, 2)
    with pytest.raises(AreaFullError):
        region.allocate(1)


def test_an_area_cannot_have_a_negative_size() -> None:
    with pytest.raises(ValueError, match="got -1"):
        Memory({Area.FLAG: -1})


def test_an_access_across_the_end_changes_nothing() -> None:
    region = Region(Area.FLAG, 4)
    with pytest.raises(MemoryRangeError) as across:
        region.write(2, b"abc")
    assert not across.value.outside
    assert region.read(0, 4) == bytes(4)
    for offset in (4, 0xFFFF_FFFF, -1):
        with pytest.raises(MemoryRangeError) as beyond:
            region.read(offset, 1)
        assert beyond.value.outside
    assert region.read(4, 0) == b""


def test_a_bit_is_a_bit_of_its_byte() -> None:
    region = Region(Area.OUTPUT, 2)
    region.write_bits(1 * 8 + 2, b"\x01")
    assert region.data == b"\x00\x04"
    region.write_bits(7, b"\xff\x01")
    assert region.data == b"\x80\x05"
    region.write_bits(8, b"\x00\x00\x00")
    assert region.data == b"\x80\x00"
    assert region.read_bits(6, 3) == b"\x00\x01\x00"
    with pytest.raises(MemoryRangeError):
        region.write_bits(15, b"\x01\x01")
    with pytest.raises(MemoryRangeError):
        region.read_bits(16, 1)


@given(st.binary(min_size=3, max_size=3), st.integers(0, 23), st.data())
def test_bits_read_back_as_written(content: bytes, number: int, data: st.DataObject) -> None:
    region = Region(Area.FLAG, 3)
    region.write(0, content)
    values = data.draw(st.binary(max_size=24 - number))
    region.write_bits(number, values)
    assert region.read_bits(number, len(values)) == bytes(map(bool, values))
    untouched = int.from_bytes(region.data, "little") ^ int.from_bytes(content, "little")
    assert untouched & ~(((1 << len(values)) - 1) << number) == 0


def test_a_cold_reset_spares_what_is_kept_and_origin_does_not() -> None:
    memory = Memory()
    data = memory[Area.DATA]
    plain, retained = data.allocate(2), data.allocate(2)
    data.keep(retained, 2)
    data.write(0, b"\x01\x02\x03\x04")
    memory.hold_initial()
    data.write(0, b"\x11\x12\x13\x14")
    memory[Area.FLAG].write(9, b"\x09")
    memory.reset()
    assert data.read(plain, 4) == b"\x01\x02\x13\x14"
    assert memory[Area.FLAG].read(9, 1) == b"\x00"
    memory.reset(origin=True)
    assert data.read(plain, 4) == b"\x01\x02\x03\x04"


def test_clearing_zeroes_an_area() -> None:
    region = Region(Area.INPUT, 4)
    region.write(1, b"\x05")
    region.clear()
    assert region.data == bytes(4)


def test_the_digest_follows_the_content() -> None:
    one, other = Memory(), Memory()
    assert one.digest() == other.digest()
    one[Area.OUTPUT].write_bits(3, b"\x01")
    assert one.digest() != other.digest()
    other[Area.OUTPUT].write(0, b"\x08")
    assert one.digest() == other.digest()


def test_bytes_allocated_after_the_initial_values_were_held_reset_to_zero() -> None:
    data = Memory()[Area.DATA]
    data.place(3, 2)
    data.write(3, b"\x07\x07")
    data.reset()
    assert not any(data.data)


def test_an_area_ends_where_the_addresses_of_pointers_end() -> None:
    region = Memory()[Area.DATA]
    with pytest.raises(AreaFullError, match="data has at most 536870912 bytes"):
        region.place((1 << 29) - 1, 2)
    assert len(region) == 0x1_0000


@pytest.mark.parametrize("size", [3 * 0x1_0000 + 5, SPARSE + 5])
def test_an_area_of_any_size_is_held_reset_copied_and_hashed(size: int) -> None:
    memory = Memory({Area.DATA: size})
    region = memory[Area.DATA]
    empty = memory.digest()
    region.write(size - 3, b"end")
    region.write(0x1_0000 - 1, b"ab")
    region.keep(7, 2)
    region.hold_initial()
    digest, copy = memory.digest(), region.snapshot()
    assert digest != empty
    region.write(size - 3, b"xyz")
    region.write(7, b"kk")
    region.write(0x2_0000, b"new")
    assert memory.digest() != digest
    region.reset()
    assert region.read(size - 3, 3) == b"end"
    assert region.read(7, 2) == b"kk"
    assert region.read(0x2_0000, 3) == bytes(3)
    region.reset(origin=True)
    assert memory.digest() == digest
    region.clear()
    assert memory.digest() == empty
    region.restore(copy)
    assert memory.digest() == digest
    region.begin_again()
    region.reset()
    assert memory.digest() == empty
    with pytest.raises(MemoryRangeError):
        region.read(size - 1, 2)


@pytest.mark.parametrize("size", [0x1_0000, SPARSE])
def test_an_area_grows_where_it_lies(size: int) -> None:
    memory = Memory({Area.DATA: size, Area.FLAG: size})
    for area in (Area.DATA, Area.FLAG):
        region, data = memory[area], memory[area].data
        region.write(size - 1, b"x")
        memory.grow({area: size + 5})
        assert region.data is data
        assert len(region) == memory.sizes[area] == size + 5
        assert region.read(size - 1, 6) == b"x" + bytes(5)
        memory.grow({area: 7})
        assert len(region) == size + 5
    memory[Area.DATA].place(SPARSE + 0x10_0000, 8)
    assert len(memory[Area.DATA]) > SPARSE + 0x10_0008
    with pytest.raises(AreaFullError, match="%M has"):
        memory[Area.FLAG].place(size, 8)


def test_where_the_system_cannot_an_area_stays_as_it_is() -> None:
    region = Memory({Area.DATA: SPARSE})[Area.DATA]
    with memoryview(region.data), pytest.raises(AreaFullError, match="cannot grow to 4194305"):
        region.grow(SPARSE + 1)
    assert len(region) == SPARSE
