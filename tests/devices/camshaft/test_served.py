"""A served controller: who looks at it wakes it; its refusals."""

from collections.abc import Callable

import pytest

from achse.ams import DeviceError
from achse.camshaft import CamController
from achse.camshaft.parameters import CAM_PARAMETERS, CONTROLLER_PARAMETERS
from achse.codes import ReturnCode
from achse.devices.camshaft.served import ServedCamshaft


def test_any_client_that_reads_wakes_it() -> None:
    woken: list[int] = []
    served = ServedCamshaft(CamController(2), wake=lambda: woken.append(1))
    assert (served.number, served.name, woken) == (2, "Camshaft 2", [])
    _ = served.cam(3)
    assert woken == []
    _ = served.cam(3).record
    served.read_outputs(0, 4)
    served.write_inputs(0, b"\1")
    assert len(woken) == 3


def test_refusals() -> None:
    served = ServedCamshaft(CamController())
    for number in (0, 129, -1):
        with pytest.raises(DeviceError) as refusal:
            served.cam(number)
        assert refusal.value.code == ReturnCode.INVALID_GROUP.number
    start = next(each for each in CAM_PARAMETERS if each.name == "start")
    rate = next(each for each in CONTROLLER_PARAMETERS if each.name == "set_rate")
    calls: list[Callable[[], None]] = [
        lambda: served.cam(1).set_value(start, 360),
        lambda: served.set_value(rate, 2001),
        lambda: served.write_encoder_set(b"\xff" * 12),
        lambda: served.write_controller_set(b"\xff" * 61),
        lambda: served.cam(1).write_set(b"\xff" * 44),
    ]
    for refuse in calls:
        with pytest.raises(DeviceError) as refusal:
            refuse()
        assert refusal.value.code == ReturnCode.INVALID_PARAMETER.number
