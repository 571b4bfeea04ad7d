"""Switching of control loops over ADS, in the forms of TwinCAT 2 and 3."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import NetId
from achse.devices.nc import NcDevice
from achse.motion import AxisParameters, Nc
from achse.router import Router


@pytest.mark.parametrize("form", ["<IIdI", "<IIdI4x"], ids=["TwinCAT 2", "TwinCAT 3"])
def test_another_loop_becomes_active(
    client_of: Callable[..., Any], refused: Any, form: str
) -> None:
    values = {"control_dword": 7, "velocity_override": 1_000_000}
    elements = [{"encoder_position_offset": 40.0}]
    nc = Nc(2_000_000, [AxisParameters(1, "X", "mm", values, (1, 2), elements=elements)])
    router = Router(NetId("5.1.2.3.1.1"))
    NcDevice(nc, clock=lambda: 0).attach(router, 501)
    client = client_of(router, 501)
    for _ in range(5):
        nc.cycle()
    with refused(0x4003):
        client.put(0x4201, 0x52, form, 2, 1, 0.0, 0)
    with refused(0x4265):
        client.put(0x4201, 0x52, form, 1, 0, 0.0, 0)
    client.put(0x4201, 0x52, form, 1, 2, 0.0, 0)
    for _ in range(5):
        nc.cycle()
    online = client.read(0x4101, 0x00, 112)
    assert int.from_bytes(online[108:112], "little") == 1
    assert client.get(0x4101, 0x1_0002, "<d") == pytest.approx(0.0, abs=1e-3)
    assert client.get(0x4301, 0xBA, "<d") == pytest.approx(40.0, abs=1e-3)
