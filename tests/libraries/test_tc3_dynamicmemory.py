"""Tc3_DynamicMemory: blocks of memory with counters, and buffers that keep their content."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.plc import Area
from tests.plc.code.conftest import Ran

PROGRAM = (
    "PROGRAM MAIN VAR manager : FB_DynMem_Manager2;"
    " buffer : FB_DynMem_Buffer(ipMemMan := manager);"
    " other : FB_DynMem_Buffer(ipMemMan := manager);"
    " size, next : UDINT := 4; keep : BOOL; value, kept : BYTE; first, held, byPlain : PVOID;"
    " p : POINTER TO BYTE; n, last : ARRAY [1..2] OF ULINT; ok : ARRAY [1..9] OF BOOL;"
    " length : UDINT; END_VAR"
    " first := manager.Alloc(size, TRUE); byPlain := manager.Alloc(size, FALSE);"
    " ok[1] := buffer.CreateBuffer(size, TRUE); ok[2] := NOT buffer.CreateBuffer(size, TRUE);"
    " n[1] := manager.nAllocatedSize; n[2] := manager.nBufferCount;"
    " p := buffer.pBuffer; p[0] := value; ok[3] := buffer.Resize(next, keep, TRUE);"
    " p := buffer.pBuffer; kept := p[0]; length := buffer.nBufferSize;"
    " ok[4] := buffer.PassBufferOwnership(held, length) AND NOT buffer.bAvailable;"
    " ok[5] := other.RetrieveBufferOwnership(held, length) AND held = 0 AND other.bAvailable;"
    " length := other.nBufferSize; ok[6] := other.Clear(); p := other.pBuffer;"
    " ok[7] := p[0] = 0; ok[8] := other.DeleteBuffer(); manager.Free2(first);"
    " ok[9] := first = 0 AND manager.Alloc(0, TRUE) = 0; manager.Free(byPlain, size);"
    " last[1] := manager.nAllocatedSize + manager.nObjectCount; last[2] := manager.nBufferCount;"
    " END_PROGRAM"
)


@pytest.fixture(scope="module")
def memory() -> Ran:
    return Ran(PROGRAM)


@settings(max_examples=12, deadline=None)
@given(
    size=st.integers(1, 300),
    following=st.integers(1, 300),
    keep=st.booleans(),
    value=st.integers(1, 255),
)
def test_memory_is_counted_and_buffers_keep_their_content(
    memory: Ran, size: int, following: int, keep: bool, value: int
) -> None:
    main = memory.plc.instance("MAIN")
    main["size"], main["next"], main["keep"], main["value"] = size, following, keep, value
    memory.cycle()
    assert memory.plc.failure == ""
    assert list(memory["ok"]) == [True] * 9
    assert list(memory["n"]) == [3 * size, 3]
    assert (memory["kept"], memory["length"]) == (value if keep else 0, following)
    assert list(memory["last"]) == [0, 0]


@pytest.mark.parametrize(
    "wrong",
    [
        "manager.Free2(copy);",
        "copy := manager.Alloc(8, TRUE) + 4; manager.Free2(copy);",
        "copy := ADR(own); manager.Free2(copy);",
    ],
    ids=["twice", "inside a block", "no block"],
)
def test_memory_that_is_not_a_block_is_not_freed(wrong: str) -> None:
    """An exception stops the PLC; other blocks keep their content."""
    ran = Ran(
        "PROGRAM MAIN VAR manager : FB_DynMem_Manager2; first, copy, kept : PVOID; own : LWORD;"
        " p : POINTER TO BYTE; last : BOOL; END_VAR kept := manager.Alloc(8, TRUE); p := kept;"
        f" p[7] := 9; first := manager.Alloc(8, TRUE); copy := first; manager.Free2(first); {wrong}"
        " last := TRUE; END_PROGRAM"
    )
    ran.cycle()
    assert "ACCESS_VIOLATION" in ran.plc.failure
    assert not ran["last"]
    offset = ran["kept"] - ran.plc.memory.address(Area.HEAP, 0)
    assert ran.plc.memory[Area.HEAP].read(offset, 8) == bytes(7) + b"\x09"
