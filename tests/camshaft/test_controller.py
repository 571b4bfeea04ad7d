"""A controller from outside: parameters, sets, process image; runs with everything drawn."""

import math
import random
import struct
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.camshaft import CamController, CamEncoder, CamInput, CamOutput
from achse.camshaft.image import INPUTS, OUTPUTS
from achse.camshaft.parameters import (
    CAM_PARAMETERS,
    CONTROLLER_PARAMETERS,
    ENCODER_PARAMETERS,
    CamParameter,
    CamParameterError,
)
from achse.native.backend import compiler_installed

BY_NAME = {each.name: each for each in (*CONTROLLER_PARAMETERS, *ENCODER_PARAMETERS)}
FLAGS = {"encoder_error", "shaft_error", "rate_error", "configured_cams"}


@given(st.sampled_from(sorted(BY_NAME)), st.data())
def test_values_are_kept_and_flags_are_reset(name: str, data: st.DataObject) -> None:
    parameter: CamParameter = BY_NAME[name]
    controller = CamController()
    value = data.draw(st.integers(parameter.least, parameter.most))
    if name in FLAGS - {"configured_cams"}:
        setattr(controller.record, name, 1)
    controller.set_value(parameter, value)
    assert controller.value(parameter) == (0 if name in FLAGS else value)
    with pytest.raises(CamParameterError):
        controller.set_value(parameter, parameter.most + 1)


def test_sets_set_all_or_nothing(shaft: Any) -> None:
    controller: CamController = shaft.controller
    controller.write_encoder_set(struct.pack("<iiB3x", -100, 200, 2))
    assert controller.encoder_set() == struct.pack("<iiB3x", -100, 200, 2)
    with pytest.raises(CamParameterError):
        controller.write_encoder_set(struct.pack("<iiB3x", 5, 5, 3))
    assert controller.encoder_set() == struct.pack("<iiB3x", -100, 200, 2)

    cam = struct.pack("<8B9I", 2, 1, 0, 1, 0, 1, 1, 0, 10, 20, 31, 100, 3, 20, 50, 7, 9)
    controller.write_cam_set(128, cam)
    assert controller.cam_set(128) == cam[:6] + b"\0" + cam[7:]  # the enable only shows
    assert controller.configured_cams == 1
    with pytest.raises(CamParameterError, match="type = 5"):
        controller.write_cam_set(1, b"\5" + cam[1:])
    assert controller.configured_cams == 1

    whole = bytearray(controller.controller_set())
    controller.record.encoder_error = 1
    whole[4] = 0
    controller.write_controller_set(bytes(whole))
    assert (controller.record.active, controller.record.encoder_error) == (0, 0)
    with pytest.raises(struct.error):
        controller.write_controller_set(bytes(whole[:-1]))


def test_another_type_forgets_what_the_cam_did(shaft: Any) -> None:
    shaft.cam(type=3, start=10, force=1)
    assert shaft.at(0) == 1
    shaft.cam(type=0)
    assert shaft.at(0) == 0
    shaft.cam(type=3, force=0)
    assert shaft.at(0) == 0
    with pytest.raises(KeyError):
        shaft.cam(nothing=1)


def test_another_type_forgets_a_brake_that_is_on(shaft: Any) -> None:
    shaft.controller.set_input(CamInput.BRAKE_ENABLE, 1)
    shaft.cam(type=3, start=90)
    assert shaft.go((80, 95, 95)) == [0, 1, 1]
    shaft.cam(type=0)
    shaft.cam(type=3)
    assert shaft.go((95, 95)) == [0, 0]


def test_the_process_image(shaft: Any) -> None:
    controller: CamController = shaft.controller
    controller.write_inputs(0x44, b"\x08\0\0\0")
    controller.set_input(CamInput.SET_RATE, -1)
    shaft.at(90)
    assert controller.inputs() == INPUTS.pack(*(0, 0, 0, 2**32 - 1), *[0] * 13, 8)
    words = OUTPUTS.unpack(controller.outputs())
    assert words[CamOutput.CAMS] == 8
    assert words[CamOutput.ANGLE] == 900
    for offset, data in ((-1, b"\0"), (0x48, b"\0"), (0, bytes(0x49))):
        with pytest.raises(ValueError, match=r"expected 0\.\.72"):
            controller.write_inputs(offset, data)


def test_when_cycles_matter() -> None:
    controller = CamController()
    assert not controller.works
    controller.set_cam(7, {"type": 1})
    assert controller.works
    controller.set_cam(7, {"type": 0})
    assert not controller.works
    controller.record.rate_monitoring = 1
    assert controller.works
    other = CamController()
    other.set_input(CamInput.OR_MASK, 1)
    assert other.works


def test_what_cannot_be_a_controller() -> None:
    for wrong in ({"cycle_ns": 0}, {"encoder": CamEncoder(0)}, {"encoder": CamEncoder(-1.0)}):
        with pytest.raises(ValueError, match="increments a turn"):
            CamController(**wrong)
    assert CamController(encoder=CamEncoder(window_ns=10**12)).record.window == 64
    assert CamController(encoder=CamEncoder(window_ns=0)).record.window == 1


# everything drawn -------------------------------------------------------------------------------


def _drawn_run(seed: int, controllers: list[CamController]) -> None:
    """A run with anything at any time, the same for all controllers."""
    draw = random.Random(seed)
    parameters = [*CONTROLLER_PARAMETERS, *ENCODER_PARAMETERS]
    position, speed = draw.uniform(-1e4, 1e4), draw.uniform(-150, 150)
    for _ in range(draw.randint(5, 60)):
        for _ in range(draw.randint(0, 4)):
            what = draw.random()
            if what < 0.4:
                number = draw.randint(1, 128)
                some = draw.sample(CAM_PARAMETERS, draw.randint(1, len(CAM_PARAMETERS)))
                values = {each.name: draw.randint(each.least, each.most) for each in some}
                if draw.random() < 0.5:
                    values |= {"count": draw.randint(1, 3), "cycles_on": 2, "duration": 9}
                for each in controllers:
                    each.set_cam(number, values)
            elif what < 0.7:
                parameter = draw.choice(parameters)
                value = draw.randint(parameter.least, parameter.most)
                for each in controllers:
                    each.set_value(parameter, value)
            else:
                word = draw.choice(list(CamInput))
                value = draw.choice((0, 1, 0xFFFF_FFFF, draw.randint(0, 0xFFFF_FFFF)))
                for each in controllers:
                    each.set_input(word, value)
        if draw.random() < 0.1:
            speed = draw.choice((0.0, draw.uniform(-150, 150), -speed))
        position += speed
        place: float | None = position
        if draw.random() < 0.03:
            place = draw.choice((None, math.nan, position + draw.uniform(-1e6, 1e6)))
        for each in controllers:
            each.take_position(place)
        outputs = {each.cycle() for each in controllers}
        digests = {each.digest() for each in controllers}
        assert len(outputs) == len(digests) == 1
        record = controllers[0].record
        assert 0 <= record.angle < 3600
        assert (record.outputs & record.or_mask) == record.or_mask
        if not record.active:
            assert record.outputs == record.or_mask | record.inputs[CamInput.OR_MASK]
        forced = record.or_mask | record.inputs[CamInput.OR_MASK]
        assert record.outputs & ~record.and_mask & ~forced == 0
        for cam in controllers[0].cams:
            assert 0 <= cam.place < 3600
            assert -3600 < cam.way < 3600
            assert 0 <= cam.stroke < 65_535 + 65_535
        controllers[0].output_words()


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 1 << 60),
    increments=st.sampled_from((360, 1000, 4096)) | st.floats(1, 1e5),
    span=st.just(0.0) | st.floats(0, 1e5),
    largest=st.floats(0, 1e5),
    window=st.integers(0, 70),
)
def test_machine_code_does_the_same(
    seed: int, increments: float, span: float, largest: float, window: int
) -> None:
    """Anything at any time: the same bytes after every cycle."""
    encoder = CamEncoder(increments, span, largest, window_ns=1_000_000 * window)
    kinds = (False, compiler_installed())
    _drawn_run(seed, [CamController(encoder=encoder, compiled=kind) for kind in kinds])
