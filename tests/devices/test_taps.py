"""Taps as a service: each belongs to the client and the connection that opened it."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, DeviceError, NetId
from achse.devices.taps import TAPS, TapService
from achse.router import Router
from achse.router.tap import Taps

CLIENTS = [bytes(AmsAddress(f"10.0.0.{number}.1.1:30000")) for number in range(3)]
STEP = st.tuples(
    st.sampled_from(("open", "open", "open", "close", "client", "way")),
    st.integers(0, 2),
    st.integers(0, 1),
)


@given(st.lists(STEP, max_size=30))
def test_taps_end_with_their_client_and_connection_and_no_others(
    steps: list[tuple[str, int, int]],
) -> None:
    router = Router(NetId("5.0.0.1.1.1"))
    ways: list[Any] = [object(), object()]
    way: Any = None
    service = TapService(Taps(router, lambda: 0), lambda: way)
    group = service.group
    expected: dict[int, tuple[int, int]] = {}
    for what, who, number in steps:
        client = CLIENTS[who]
        if what == "open":
            way = ways[number]
            full = sum(owner == who for owner, _ in expected.values()) == 4
            if full:
                with pytest.raises(DeviceError, match="0x716"):
                    group.read_write(TAPS, 0, 4, b"", client)
            else:
                data = group.read_write(TAPS, 0, 4, b"", client)
                expected[int.from_bytes(data, "little")] = who, number
        elif what == "close" and expected:
            tap = next(iter(expected))
            if expected[tap][0] == who:
                group.write(TAPS, tap, b"", client)
                del expected[tap]
            else:
                with pytest.raises(DeviceError, match="0x70C"):
                    group.write(TAPS, tap, b"", client)
        elif what == "client":
            service.end_client(client)
            expected = {tap: each for tap, each in expected.items() if each[0] != who}
        elif what == "way":
            service.end_way(ways[number])
            expected = {tap: each for tap, each in expected.items() if each[1] != number}
        assert service.clients == {CLIENTS[owner] for owner, _ in expected.values()}
        assert router.attended == bool(expected)
