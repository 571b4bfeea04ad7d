"""Views of PLC memory."""

import pytest

from achse.plc.code.views import FORMATS, Views
from achse.plc.memory import ADDRESS_BITS, Area, Memory


def test_all_views_are_of_the_same_bytes() -> None:
    memory = Memory()
    views = Views(memory)
    views.renew()
    views.named["D_i"][3] = -2
    assert views.named["D_H"][6] == 0xFFFE
    assert memory[Area.DATA].read(12, 4) == b"\xfe\xff\xff\xff"
    number = memory.address(Area.DATA, 0) >> ADDRESS_BITS
    assert all(len(views.by_area[code]) == len(Area) + 1 for code in FORMATS)
    assert views.by_area["i"][number][3] == -2


def test_an_area_grows_only_without_views() -> None:
    memory = Memory()
    views = Views(memory)
    views.renew()
    with pytest.raises(ValueError, match="cannot grow"):
        memory[Area.DATA].grow(1 << 20)
    views.release()
    memory[Area.DATA].grow(1 << 20)
    views.renew()
    views.named["D_B"][(1 << 20) - 1] = 7
    assert memory[Area.DATA].data[-1] == 7


def test_address_0_has_no_memory() -> None:
    views = Views(Memory())
    views.renew()
    with pytest.raises(IndexError):
        views.by_area["d"][0][0]
