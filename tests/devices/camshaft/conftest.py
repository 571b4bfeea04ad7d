"""Four controllers at port 900, without a station."""

from typing import Any

import pytest

from achse.ams import NetId
from achse.camshaft import CamController
from achse.devices.camshaft import CAMSHAFT_PORT, CamshaftDevice, ServedCamshaft
from achse.router import Router


@pytest.fixture
def camshafts() -> list[ServedCamshaft]:
    """Controllers 1, 2 and 4 of the manual's four; the first has names."""
    return [
        ServedCamshaft(CamController(1), "Press", {3: "Blow"}),
        ServedCamshaft(CamController(2)),
        ServedCamshaft(CamController(4)),
    ]


@pytest.fixture
def device(camshafts: list[ServedCamshaft]) -> CamshaftDevice:
    result = CamshaftDevice(camshafts, clock=lambda: 0)
    result.attach(Router(NetId("1.2.3.4.1.1")), CAMSHAFT_PORT)
    return result


@pytest.fixture
def camshaft(device: CamshaftDevice, client_of: Any) -> Any:
    """A client of port 900."""
    return client_of(device._router, CAMSHAFT_PORT)
