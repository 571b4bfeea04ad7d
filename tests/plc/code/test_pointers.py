"""Memory by address: numbers of all widths, aligned or not, within every area and not beyond."""

from contextlib import suppress
from functools import partial
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.plc.code.faults import PlcFault
from achse.plc.code.pointers import pointer_operations
from achse.plc.code.views import FORMATS, Views
from achse.plc.memory import Area, Memory
from tests.plc.code.conftest import Ran

MEMORY = Memory()
VIEWS = Views(MEMORY)
VIEWS.renew()
OF: dict[str, Any] = pointer_operations(VIEWS)


@given(st.sampled_from(list(Area)[:5]), st.integers(0, 65_535), st.sampled_from(FORMATS[:8]))
def test_what_is_stored_is_loaded_at_any_alignment(area: Area, offset: int, code: str) -> None:
    size = {"b": 1, "h": 2, "i": 4, "q": 8}[code.lower()]
    address = MEMORY.address(area, offset)
    if offset + size > len(MEMORY[area]):
        with pytest.raises(PlcFault, match="ACCESS_VIOLATION"):
            OF[f"store_{code}"](address, 1)
        return
    assert OF[f"store_{code}"](address, 100) == 100
    assert OF[f"load_{code}"](address) == 100


@given(st.integers(0, (1 << 64) - 1), st.integers(0, 100))
def test_no_address_reaches_beyond_plc_memory(address: int, size: int) -> None:
    accesses = {name: partial(OF[name], address) for name in ("load_B", "load_d", "load_h")}
    accesses["load_bytes"] = partial(OF["load_bytes"], address, size)
    for name, ask in accesses.items():
        if name == "load_B" and MEMORY.at(address) is not None:
            assert 0 <= ask() <= 255
            continue
        with suppress(PlcFault):
            assert name != "load_bytes" or len(ask()) == size


def test_texts_bits_and_parts() -> None:
    address = MEMORY.address(Area.DATA, 100)
    OF["store_bytes"](address, b"abcdefgh\0")
    OF["store_text"](address, b"xy")
    assert OF["load_bytes"](address, 9) == b"xy\0defgh\0"
    assert OF["load_text"](address, 8) == b"xy"
    OF["store_wide"](address, "äb".encode("utf-16-le"))
    assert OF["load_wide"](address, 8).decode("utf-16-le") == "äb"
    OF["store_B"](address, 0)
    assert OF["store_bit"](address, 4, True) is True
    assert OF["load_B"](address) == 4
    assert OF["store_bit"](address, 4, False) is False
    assert OF["load_B"](address) == 0
    OF["store_parts"](address, b"12345678", ((0, 2), (4, 8)))
    assert OF["load_bytes"](address, 2) == b"12"


@settings(max_examples=5)
@given(number=st.integers(-(2**15), 2**15 - 1), at=st.integers(0, 2))
def test_raw_memory_becomes_a_block_by_an_assignment(number: int, at: int) -> None:
    ran = Ran(
        "FUNCTION_BLOCK FB_Inner VAR_OUTPUT n : INT; END_VAR"
        " METHOD Get : INT Get := n; END_METHOD END_FUNCTION_BLOCK"
        " FUNCTION_BLOCK FB VAR_INPUT n : INT; END_VAR VAR fb : FB_Inner; END_VAR"
        " METHOD Set VAR_INPUT x : INT; END_VAR n := x; fb.n := x; END_METHOD"
        " METHOD Sum : INT Sum := n - fb.Get() + n; END_METHOD END_FUNCTION_BLOCK"
        " PROGRAM MAIN VAR fb : FB; p : POINTER TO FB; sum : INT; END_VAR"
        f" fb.Set({number}); p := __NEW(BYTE, TO_UDINT(SIZEOF(FB) * 3)); p[{at}] := fb;"
        f" sum := p[{at}].Sum(); __DELETE(p); END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    assert ran["sum"] == number
