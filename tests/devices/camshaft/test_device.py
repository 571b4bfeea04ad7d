"""Port 900: every row of the manual's tables, its errors, all controllers, hostile requests."""

import csv
import random
import struct
from pathlib import Path
from typing import Any

import pytest

from achse.camshaft import CAMS
from achse.camshaft.image import INPUTS, OUTPUTS
from achse.camshaft.parameters import (
    CAM_PARAMETERS,
    CONTROLLER_PARAMETERS,
    ENCODER_PARAMETERS,
)
from achse.codes import ReservedGroup, ReturnCode
from achse.devices.camshaft import CamshaftDevice, ServedCamshaft
from achse.devices.camshaft.device import CAMSHAFT_PORT, IMAGE_STEP

with (Path(__file__).parents[2] / "data" / "camshaft_services.tsv").open(encoding="utf-8") as file:
    ROWS = list(csv.DictReader(file, delimiter="\t"))

GROUPS = {"encoder": 0x1001, "controller": 0x1000, "cam": 0x1101}
PARAMETERS = {
    0x1000: {each.offset: each for each in CONTROLLER_PARAMETERS},
    0x1001: {each.offset: each for each in ENCODER_PARAMETERS},
    0x1101: {each.offset: each for each in CAM_PARAMETERS},
}
FLAGS = {0x20, 0x21, 0x22}
CONTROLLERS = (1, 2, 4)
CAM = struct.pack("<8B9I", 1, 1, 1, 0, 0, 0, 0, 0, 90, 180, 4, 0, 1, 0, 1, 0, 2)


def test_the_table_is_whole() -> None:
    assert len(ROWS) == 45
    assert CAMSHAFT_PORT == 900


@pytest.mark.parametrize("number", CONTROLLERS)
@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row['part']} {row['offset']}")
def test_every_row_is_served_as_the_table_says(
    camshaft: Any, refused: Any, row: dict[str, str], number: int
) -> None:
    """Access, length and range of each row, at each controller; cams at both ends."""
    group, offset, size = GROUPS[row["part"]], int(row["offset"], 16), int(row["bytes"])
    parameter = PARAMETERS[group].get(offset)
    base = group + (number - 1) * 0x1000
    for place in (base, base + CAMS - 1) if row["part"] == "cam" else (base,):
        before = camshaft.read(place, offset, 1000)
        assert len(before) == size
        assert camshaft.read(place, offset, 0) == b""
        if row["set_by_clients"] == "no":
            with refused(0x704):
                camshaft.write(place, offset, before)
            continue
        camshaft.write(place, offset, before)
        assert camshaft.read(place, offset, 1000) == before
        for wrong in (b"", before + b"\0", before[:-1], bytes(1000)):
            if len(wrong) != 2 or parameter is None or parameter.code != "i":
                with refused(0x705):
                    camshaft.write(place, offset, wrong)
        if parameter is None:
            continue
        for value in (parameter.least, parameter.most):
            camshaft.write(place, offset, struct.pack("<" + parameter.code, value))
            stored = struct.unpack("<" + parameter.code, camshaft.read(place, offset, size))[0]
            assert stored == (0 if group == 0x1000 and offset in FLAGS else value)
        for value in (parameter.least - 1, parameter.most + 1):
            try:
                content = struct.pack("<" + parameter.code, value)
            except struct.error:
                continue
            with refused(0x70B):
                camshaft.write(place, offset, content)


def test_numbers_of_the_encoder_may_have_two_bytes(camshaft: Any, refused: Any) -> None:
    camshaft.write(0x1001, 0x201, struct.pack("<h", -5))
    assert camshaft.read(0x1001, 0x201, 4) == struct.pack("<i", -5)
    assert camshaft.read(0x1001, 0x201, 2) == struct.pack("<h", -5)
    with refused(0x705):
        camshaft.write(0x1001, 0x201, b"\1")


def test_groups_that_are_not_there(camshaft: Any, refused: Any) -> None:
    """Reserved groups, cam 0, cams above 128, a controller that is not configured."""
    for group in (0, 0xFFF, 0x1002, 0x10FF, 0x1100, 0x1181, 0x3000, 0x3001, 0x3101, 0x5000):
        with refused(0x702):
            camshaft.read(group, 0, 4)
        with refused(0x702):
            camshaft.write(group, 0, b"\0")
    for group in (0x1000, 0x1001, 0x1101, 0x2101):
        for offset in (0x18, 0x36, 0x102, 0x306, 0xFFFF_FFFF):
            with refused(0x703):
                camshaft.read(group, offset, 4)


def test_a_cam_gets_its_type_by_the_whole_set(
    camshaft: Any, camshafts: list[ServedCamshaft], refused: Any
) -> None:
    camshaft.write(0x1180, 0, CAM)
    assert camshaft.read(0x1180, 1, 1) == b"\1"
    assert camshaft.read(0x1000, 1, 4) == b"\1\0\0\0"
    assert camshaft.read(0x1180, 0, 44) == CAM
    for at, value in ((0, 5), (1, 2)):
        wrong = bytearray(CAM)
        wrong[at] = value
        with refused(0x70B):
            camshaft.write(0x1180, 0, bytes(wrong))
    controller = camshafts[0].controller
    controller.take_position(4096 / 3)
    controller.cycle()
    assert camshaft.read(ReservedGroup.OUTPUTS, 0x40, 4) == b"\x10\0\0\0"


def test_errors_are_reset_by_writing_them(camshaft: Any, camshafts: list[ServedCamshaft]) -> None:
    record = camshafts[1].controller.record
    for offset, name in ((0x20, "encoder_error"), (0x21, "shaft_error"), (0x22, "rate_error")):
        for value in (b"\0", b"\1"):
            setattr(record, name, 1)
            assert camshaft.read(0x2000, offset, 1) == b"\1"
            camshaft.write(0x2000, offset, value)
            assert camshaft.read(0x2000, offset, 1) == b"\0"


def test_the_process_image(camshaft: Any, refused: Any) -> None:
    inputs, outputs = ReservedGroup.INPUTS, ReservedGroup.OUTPUTS
    for number in CONTROLLERS:
        first = (number - 1) * IMAGE_STEP
        camshaft.write(inputs, first + 0x44, b"\7\0\0\0")
        assert camshaft.read(inputs, first, 1000) == bytes(0x44) + b"\7\0\0\0"
        assert len(camshaft.read(outputs, first, 1000)) == OUTPUTS.size
        assert camshaft.read(outputs, first + 0x42, 1000) == bytes(2)
        for offset in (first + INPUTS.size, first + IMAGE_STEP - 1):
            with refused(0x703):
                camshaft.read(inputs, offset, 1)
            with refused(0x703):
                camshaft.write(inputs, offset, b"\0")
        for offset, data in ((0, bytes(INPUTS.size + 1)), (0x47, b"\0\0"), (4, b"")):
            with refused(0x705):
                camshaft.write(inputs, first + offset, data)
    for offset in (2 * IMAGE_STEP, 4 * IMAGE_STEP, 0xFFFF_FFFF):
        with refused(0x703):
            camshaft.read(inputs, offset, 4)
    with refused(0x704):
        camshaft.write(outputs, 0, b"\0\0\0\0")


def test_tracks_are_bits_of_the_process_image(
    camshaft: Any, camshafts: list[ServedCamshaft], refused: Any
) -> None:
    bits = ReservedGroup.OUTPUT_BITS
    for number in CONTROLLERS:
        first = (number - 1) * IMAGE_STEP * 8
        served = next(each for each in camshafts if each.number == number)
        served.controller.record.outputs = 1 << 31 | 1
        tracks = camshaft.read(bits, first + 0x40 * 8, 1000)
        assert tracks == b"\1" + bytes(30) + b"\1"
        for offset in (first + 8 * OUTPUTS.size, first + 8 * IMAGE_STEP - 1):
            with refused(0x703):
                camshaft.read(bits, offset, 1)
        with refused(0x704):
            camshaft.write(bits, first, b"\1")
    with refused(0x703):
        camshaft.read(bits, 2 * IMAGE_STEP * 8, 1)


def test_handles_lead_to_cams(camshaft: Any, refused: Any) -> None:
    """F003 … F006, with offset 0 or the handle at the release."""
    camshaft.write(0x1103, 2, struct.pack("<I", 77))
    for offset_is_handle in (False, True):
        handle = camshaft.exchange(0xF003, 0, 4, b"Press.Blow.start\0")
        number = struct.unpack("<I", handle)[0]
        assert camshaft.read(0xF005, number, 4) == struct.pack("<I", 77)
        camshaft.write(0xF005, number, struct.pack("<I", 77))
        with refused(0x70B):
            camshaft.write(0xF005, number, struct.pack("<I", 360))
        camshaft.write(0xF006, number if offset_is_handle else 0, handle)
        with refused(0x710):
            camshaft.read(0xF005, number, 4)
    assert camshaft.exchange(0xF004, 0, 4, b"press.cam3.START") == struct.pack("<I", 77)
    with refused(0x710):
        camshaft.exchange(0xF003, 0, 4, b"Press.Nothing.start")


def test_hostile_requests_change_nothing_but_values(
    device: CamshaftDevice, camshaft: Any, camshafts: list[ServedCamshaft]
) -> None:
    """Any group, offset, length and content: an answer with a code of the manual, values within
    their ranges, and the controllers go on."""
    draw = random.Random(900)
    groups = [*device.services.by_index, 0, 0x1100, 0x1181, 0x3000, 0xFFFF_FFFF]
    offsets = [each.offset for table in PARAMETERS.values() for each in table.values()]
    codes = set()
    allowed = {0x702, 0x703, 0x704, 0x705, 0x706, 0x70B, 0x710, 0x711, 0x714, 0x716, 0x701, 0x70C}
    for _ in range(6000):
        group = draw.choice(groups)
        offset = draw.choice((*offsets, 0, 0xFFFF_FFFF, draw.randrange(1 << 32), IMAGE_STEP))
        length = draw.choice((0, 1, 2, 4, 12, 44, 61, 0xFFFF_FFFF))
        content = draw.randbytes(draw.choice((0, 1, 2, 3, 4, 8, 12, 44, 61, 72, 3000)))
        code = 0
        try:
            match draw.randrange(3):
                case 0:
                    camshaft.read(group, offset, length)
                case 1:
                    camshaft.write(group, offset, content)
                case _:
                    camshaft.exchange(group, offset, length, content)
        except Exception as refusal:
            code = int(getattr(refusal, "code", -1))
            codes.add(code)
        assert code != ReturnCode.INTERNAL_ERROR.number
        assert code in allowed | {0}, hex(code)
        served = draw.choice(camshafts)
        served.controller.take_position(draw.uniform(-1e6, 1e6))
        served.controller.cycle()
    assert codes >= {0x702, 0x703, 0x704, 0x705, 0x70B}
    for served in camshafts:
        for parameter in CONTROLLER_PARAMETERS:
            # the actual rate is what it is: the encoder jumped wildly
            if parameter.name != "actual_rate":
                assert parameter.check(served.controller.value(parameter)) >= 0
        for cam in served.controller.cams:
            for parameter in CAM_PARAMETERS:
                parameter.check(getattr(cam, parameter.name))


def test_a_write_without_data_is_refused(camshaft: Any, refused: Any) -> None:
    for group, rows in PARAMETERS.items():
        for offset, row in rows.items():
            if row.writable:
                with refused(0x705):
                    camshaft.write(group, offset, b"")
    with refused(0x705):
        camshaft.write(ReservedGroup.INPUTS, 0, b"")
