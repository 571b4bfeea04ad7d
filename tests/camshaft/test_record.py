"""Records: defaults that are values, and that act."""

from typing import Any

from achse.camshaft.parameters import CAM_PARAMETERS, CONTROLLER_PARAMETERS, ENCODER_PARAMETERS
from achse.camshaft.record import CAM, CONTROLLER
from achse.native.declare import plain_record


def test_defaults_are_within_the_ranges() -> None:
    cam: Any = plain_record(CAM)()
    for each in CAM_PARAMETERS:
        assert each.least <= getattr(cam, each.name) <= each.most
    controller: Any = plain_record(CONTROLLER)()
    for each in (*CONTROLLER_PARAMETERS, *ENCODER_PARAMETERS):
        if not each.name.startswith("counter_"):
            assert each.least <= getattr(controller, each.name) <= each.most


def test_a_cam_without_type_acts_in_both_directions_once_it_has_one() -> None:
    cam: Any = plain_record(CAM)()
    assert (cam.type, cam.forward, cam.backward, cam.count) == (0, 1, 1, 1)
