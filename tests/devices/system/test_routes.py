"""Route services: entries byte by byte, changes, refusals."""

import errno
import struct
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import DeviceError, NetId
from achse.devices.system import SystemDevice
from achse.devices.system.routes import RouteEntry
from achse.router import Router
from achse.router.routes import Route

BY_A_TOOL = (
    bytes([5, 1, 1, 1, 1, 1])
    + bytes([1, 0, 32])
    + bytes(23)
    + bytes([9])
    + bytes(3)
    + bytes([5])
    + bytes(7)
    + b"10.0.0.1\0mill\0"
)
"""How a C# tool writes a route to group 801."""


def test_the_list_has_its_fields_where_real_targets_have_them(client: Any) -> None:
    entry = client.read(803, 0, 0xFFFF)
    assert entry[:6] == bytes([5, 9, 9, 9, 1, 1])
    assert struct.unpack_from("<HIII", entry, 6) == (1, 0x20, 5000, 0)
    assert struct.unpack_from("<II", entry, 32) == (9, 6)
    assert entry[44:] == b"10.0.0.9\0press\0"


def test_behind_the_last_route_the_list_ends(client: Any, refused: Any) -> None:
    with refused(0x716):
        client.read(803, 1, 0xFFFF)


def test_a_route_of_a_tool_is_added_and_removed(client: Any, router: Router, refused: Any) -> None:
    client.write(801, 0, BY_A_TOOL)
    mill = Route(name="mill", net_id=NetId("5.1.1.1.1.1"), host="10.0.0.1")
    assert list(router.routes)[1] == mill
    client.write(802, 0, b"MILL\0")
    assert router.routes.named("mill") is None
    with refused(0x70C):
        client.write(802, 0, b"mill\0")


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (BY_A_TOOL[:43], 0x705),
        (BY_A_TOOL[:-1], 0x705),
        (BY_A_TOOL[:32] + b"\xff\xff\xff\xff" + BY_A_TOOL[36:], 0x705),
        (bytes(6) + BY_A_TOOL[6:], 0x706),
        (BY_A_TOOL[:-5] + bytes(5), 0x706),
    ],
)
def test_what_is_no_route_is_refused(client: Any, refused: Any, data: bytes, code: int) -> None:
    with refused(code):
        client.write(801, 0, data)


def test_a_full_table_has_no_more_room(client: Any, router: Router, refused: Any) -> None:
    router.routes.limit = 1
    with refused(0x716):
        client.write(801, 0, BY_A_TOOL)


def test_a_route_of_the_configuration_is_neither_replaced_nor_removed(
    client: Any, router: Router, refused: Any
) -> None:
    router.routes.add(Route(name="mill", net_id=NetId("5.1.1.1.1.1"), host="10.0.0.5"), fixed=True)
    with refused(0x723):
        client.write(801, 0, BY_A_TOOL)
    with refused(0x723):
        client.write(802, 0, b"mill\0")
    assert [route.host for route in router.routes] == ["10.0.0.9", "10.0.0.5"]


def test_a_route_that_cannot_be_kept_is_refused(client: Any, router: Router, refused: Any) -> None:
    def refuse(_: object) -> None:
        raise OSError(errno.ENOSPC, "no space")

    router.routes.keep = refuse
    with refused(0x700):
        client.write(801, 0, BY_A_TOOL)
    with refused(0x700):
        client.write(802, 0, b"press\0")
    assert [route.name for route in router.routes] == ["press"]


def test_refused_change_leaves_a_warning_with_its_reason(
    client: Any, router: Router, refused: Any, caplog: pytest.LogCaptureFixture
) -> None:
    router.routes.add(Route(name="mill", net_id=NetId("5.1.1.1.1.1"), host="10.0.0.5"), fixed=True)
    for group, data, wish, code, why in (
        (801, BY_A_TOOL, "add route", 0x723, "route 'mill' is fixed"),
        (802, b"MILL\0", "remove route 'MILL'", 0x723, "route 'mill' is fixed"),
        (801, BY_A_TOOL[:43], "add route", 0x705, "a route has 44 bytes or more"),
    ):
        caplog.clear()
        with refused(code):
            client.write(group, 0, data)
        [record] = caplog.records
        text = record.getMessage()
        assert record.levelname == "WARNING"
        assert text.startswith(
            f"refusing a route request of {client.address}, {wish}: {why}: 0x{code:X} "
        )


def test_flood_of_refused_changes_leaves_few_lines(
    client: Any, refused: Any, clock: Any, caplog: pytest.LogCaptureFixture
) -> None:
    for _ in range(30):
        with refused(0x705):
            client.write(801, 0, b"")
    assert len(caplog.records) == 3
    clock.now += 1_000_000_000
    with refused(0x705):
        client.write(801, 0, b"")
    assert caplog.messages[-1].endswith(" (27 more left out)")


def test_without_permission_routes_cannot_be_changed(
    client_of: Callable[..., Any], refused: Any
) -> None:
    router = Router(NetId("5.1.2.3.1.1"))
    SystemDevice(clock=lambda: 0, routes=router.routes).attach(router, 10_000)
    client = client_of(router, 10_000)
    for group in (801, 802):
        with refused(0x723):
            client.write(group, 0, BY_A_TOOL)


texts = st.text(st.characters(codec="cp1252", exclude_characters="\0"), max_size=40)
numbers = st.integers(0, 0xFFFF_FFFF)


@given(
    st.builds(
        RouteEntry,
        st.binary(min_size=6, max_size=6).map(NetId),
        texts,
        texts,
        numbers,
        numbers,
        numbers,
        st.integers(0, 0xFFFF),
    )
)
def test_an_entry_survives_the_wire(entry: RouteEntry) -> None:
    assert RouteEntry.decode(entry.encode()) == entry


@given(st.binary(max_size=120))
def test_any_bytes_are_an_entry_or_refused(data: bytes) -> None:
    code = 0x705
    try:
        RouteEntry.decode(data).route()
    except DeviceError as refusal:
        code = refusal.code
    assert code in (0x705, 0x706)
