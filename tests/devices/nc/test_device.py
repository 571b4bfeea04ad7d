"""The NC device: ids, groups, ports, and its rows against the list of the manual's services."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.ams.commands import EmptyRequest
from achse.codes import NcError
from achse.devices.nc import NcDevice
from achse.devices.nc.device import AXIS_GROUPS
from achse.devices.nc.layouts import REAL64
from achse.motion import AxisParameters, Nc
from achse.router import Router
from achse.server import READ, READ_WRITE, WRITE, Service

SERVICES = Path(__file__).parents[2] / "data" / "nc_services.tsv"


class Listed(NamedTuple):
    """A service of the manual; element and object numbers (n, nn) are those of the first."""

    group: int
    offset: int
    access: str
    name: str


def listed() -> Iterator[Listed]:
    for line in SERVICES.read_text(encoding="utf-8").splitlines()[1:]:
        _, _, group, offset, access, name = line.split("\t")
        yield Listed(int(group, 16), int(offset.replace("n", "0"), 16), access, name)


MUST_BE_THERE = {
    0x1000: {"saf_cycle_time"},
    0x1100: {"axis_count", "axis_ids", "encoder_ids", "controller_ids", "drive_ids"},
    0x4000: {
        "axis_id", "axis_name", "physical_unit", "max_velocity", "max_acceleration",
        "max_deceleration", "default_acceleration", "default_deceleration", "default_jerk",
        "position_range_monitoring_enable", "position_range_window",
        "target_position_monitoring_enable", "target_position_window",
        "target_position_monitoring_time", "override_type", "encoder_scaling_factor",
        "encoder_modulo_factor", "encoder_soft_limit_min_enable", "encoder_soft_limit_max_enable",
        "encoder_soft_limit_min", "encoder_soft_limit_max", "controller_position_kv",
        "controller_velocity_feedforward_weight", "drive_reference_velocity",
        "controller_following_error_position_monitoring_enable",
        "controller_following_error_position_max",
        "controller_following_error_position_filter_time",
    },
    0x4100: {
        "axis_online_structure", "error_code", "set_position", "set_position_modulo",
        "set_velocity", "set_acceleration", "set_jerk", "target_position",
        "encoder_actual_position", "encoder_actual_position_modulo", "encoder_actual_velocity",
        "encoder_actual_acceleration", "controller_following_error_position",
    },
    0x4200: {
        "reset", "stop", "emergency_stop", "new_end_position", "universal_axis_start",
        "set_actual_position", "start", "start_extended", "disable", "enable",
    },
    0x4300: {
        "control_dword", "controller_enable", "feed_enable_plus", "feed_enable_minus",
        "velocity_override", "nc_to_plc_structure", "state_dword", "error_code",
    },
}  # fmt: skip
"""What the first NC has by all means; further services come, none of these goes."""


OF_THE_LIBRARY = {
    *(0x3_0031, 0x3_0032, 0x3_0033),
    *(0x3_010D, 0x3_010E, 0x3_010F, 0x3_0110, 0x3_0111, 0x3_0112),
}
"""Parameters of the drive which the PLC library asks at the axis; manuals print the drive's."""


OF_CHANNELS = {0x0, 0x10201, 0x10301}
"""The structure from the PLC can be written; the manual prints one zero shift for all axes."""


OF_OURS = {0x8000_0001, 0x8000_0002}
"""What no real NC has: the path that a program takes, for pictures of it."""


def test_every_row_is_a_service_of_the_manual(bench: Any) -> None:
    known = set(listed())
    unknown = [
        row
        for group in bench.device.services
        for row in group.describe()
        if row.index_group < 0xF000
        and Listed(
            row.index_group, row.index_offset, str(row.access).replace("R W", "RW"), row.name
        )
        not in known
    ]
    assert {row.index_offset for row in unknown} == OF_THE_LIBRARY | OF_CHANNELS | OF_OURS


def test_rows_are_there(bench: Any) -> None:
    served: dict[int, set[str]] = {}
    for row in bench.device.services.describe():
        served.setdefault(row.index_group, set()).add(row.name)
    missing = {hex(group): names - served[group] for group, names in MUST_BE_THERE.items()}
    assert not any(missing.values()), missing


def test_every_row_refuses_with_a_code_that_a_table_names() -> None:
    codes = {row.code for _, rows, _ in AXIS_GROUPS for row in rows if isinstance(row.code, int)}
    assert len(codes) > 40
    assert [hex(code) for code in codes if NcError.of(code) is None] == []


@pytest.mark.parametrize("axis_id", [0, 2, 4, 255])
def test_an_id_that_no_axis_has(bench: Any, refused: Any, axis_id: int) -> None:
    for base, offset, error in (
        (0x2000, 0x01, 0x4010),
        (0x3000, 0x01, 0x4011),
        (0x3100, 0x01, 0x4011),
        (0x4000, 0x27, 0x4012),
        (0x4100, 0x00, 0x4012),
        (0x4300, 0x01, 0x4012),
        (0x5000, 0x06, 0x4013),
        (0x5100, 0x02, 0x4013),
        (0x6000, 0x102, 0x4014),
        (0x6100, 0x0F, 0x4014),
        (0x7000, 0x101, 0x4015),
        (0x7100, 0x02, 0x4015),
    ):
        with refused(error):
            bench.read(base + axis_id, offset, 8)
    with refused(0x4012):
        bench.write(0x4200 + axis_id, 0x01)
    with refused(0x4012):
        bench.put(0x4200 + axis_id, 0x20, "<I4xdd", 1, 1.0, 1.0)
    with refused(0x4012):
        bench.read(0x4100 + axis_id, 0x7777, 4)  # the axis is the first thing missing


@pytest.mark.parametrize("group", [0x0FFF, 0x1001, 0x2400, 0x4400, 0x8000])
def test_index_groups_of_no_object(bench: Any, refused: Any, group: int) -> None:
    with refused(0x702):
        bench.read(group, 0, 4)


def test_both_ports_answer_for_the_same_axes(bench: Any, client_of: Any) -> None:
    other = client_of(bench.client.router, 500)
    bench.put(0x4001, 0x10, "<d", 3.25)
    assert other.get(0x4001, 0x10, "<d") == 3.25
    assert [address.port for address in bench.device.addresses] == [500, 501]


def test_the_device_says_who_it_is(bench: Any) -> None:
    info = bench.client.ask(Command.READ_DEVICE_INFO, EmptyRequest())
    assert (info.name, info.major, info.minor) == ("TwinCAT NC", 3, 1)
    state = bench.client.ask(Command.READ_STATE, EmptyRequest())
    assert (state.ads_state, state.device_state) == (5, 0)


def test_an_error_reply_has_its_full_length(bench: Any) -> None:
    answers: list[Frame] = []

    class Listener:
        def deliver(self, frame: Frame) -> bool:
            answers.append(frame)
            return True

    router = bench.client.router
    me = router.register(0, Listener())
    request = (0x4105).to_bytes(4, "little") + bytes(4) + (112).to_bytes(4, "little")
    router.deliver(Frame(AmsAddress.of(router.net_id, 501), me, Command.READ, data=request))
    assert answers[0].data == (0x4012).to_bytes(4, "little") + bytes(4)


def test_rows_serve_the_compiled_kernel_alike() -> None:
    from achse.motion.axis import ObjectAxis, WordsAxis

    fields = {row.field for _, rows, _ in AXIS_GROUPS for row in rows if row.field}
    assert all(hasattr(ObjectAxis, field) and hasattr(WordsAxis, field) for field in fields)


def test_what_happens_to_an_axis_is_notified(bench: Any) -> None:
    bench.client.subscribe(0x4101, 0x0A, 8, cycle_s=0.01)
    bench.start(10.0, 100.0)
    for _ in range(50):
        bench.run(0.002)
        bench.device.notifications.tick(bench.nc.cycle_count * 2_000_000)
    samples = bench.client.samples()
    assert len(samples) == pytest.approx(11, abs=1)
    assert len({data for _, data in samples}) >= 10


ROWS = [
    pytest.param(base + 1, row, id=f"0x{base:X}:0x{row.offset:X} {row.name}")
    for base, rows, _ in AXIS_GROUPS
    for row in rows
    if base & 0xF00 != 0x200  # functions are met where they are defined
]


def codecs(row: Service) -> tuple[Any, ...]:
    return row.codec if isinstance(row.codec, tuple) else (row.codec,)


@pytest.mark.parametrize(("group", "row"), ROWS)
def test_each_row_has_its_length_access_and_range(
    idle: Any, refused: Any, group: int, row: Service
) -> None:
    bench = idle
    if READ in row.access:
        for codec in codecs(row):
            size = codec.size or 64
            assert len(bench.read(group, row.offset, size)) == size
        assert bench.read(group, row.offset, 1) == bench.read(group, row.offset, 4096)[:1]
    elif READ_WRITE not in row.access:
        with refused(0x704):
            bench.read(group, row.offset, 4)
    if WRITE in row.access:
        with refused(0x705):
            bench.write(group, row.offset, bytes(3))
        if READ in row.access:
            for codec in codecs(row):
                before = bench.read(group, row.offset, codec.size)
                if "setpoint_structure" in row.name:
                    with refused(0x42E3):
                        bench.write(group, row.offset, before)
                else:
                    bench.write(group, row.offset, before)
                    assert bench.read(group, row.offset, codec.size) == before
        for value in beyond(row):
            with refused(int(row.code)):
                bench.write(group, row.offset, codecs(row)[0].encode(value))
    else:
        with refused(0x704):
            bench.write(group, row.offset, bytes(8))


def beyond(row: Service) -> list[float]:
    """Values just outside the range that the row's own layout can carry."""
    codec = codecs(row)[0]
    real = codec is REAL64
    signed = real or getattr(codec, "signed", False)
    values: list[float] = []
    if row.minimum is not None and (row.minimum > 0 or signed):
        low = row.minimum - max(1.0, abs(row.minimum))
        values.append(low if real else int(low))
    if row.maximum is not None:
        high = row.maximum + max(1.0, abs(row.maximum))
        if real or high < 1 << 8 * (codec.size or 0):
            values.append(high if real else int(high))
    if real:
        values.append(math.nan)
    return values


@pytest.fixture
def idle(make_bench: Any) -> Any:
    """A bench whose axis 1 is not enabled, so that every parameter can be written."""
    return make_bench(control_dword=0)


def test_parameters_that_scale_are_fixed_while_enabled(bench: Any, refused: Any) -> None:
    guarded = [
        (group, row)
        for base, rows, _ in AXIS_GROUPS
        for group in (base + 1,)
        for row in rows
        if row.guard is not None and WRITE in row.access
    ]
    names = {row.name for _, row in guarded}
    assert {
        "scaling_factor", "scaling_numerator", "scaling_denominator", "scaling_factor_components",
        "position_offset", "count_direction", "reference_system", "encoder_mask", "motor_polarity",
        "encoder_scaling_factor", "drive_motor_polarity",
    } <= names  # fmt: skip
    for group, row in guarded:
        data = bench.read(group, row.offset, codecs(row)[0].size)
        with refused(0x4257):
            bench.write(group, row.offset, data)


def test_elements_are_reached_by_id_and_by_number(client_of: Any, refused: Any) -> None:
    nc = Nc(
        2_000_000,
        [
            AxisParameters(
                1,
                "X",
                encoder_ids=(1, 77),
                elements=[{"encoder_modulo_factor": 90.0}],
            ),
            AxisParameters(2, "Y", encoder_ids=(3,), controller_ids=(5,), drive_ids=(6,)),
        ],
        compiled=False,
    )
    device = NcDevice(nc, clock=lambda: 0)
    router = Router(NetId("5.1.2.3.1.1"))
    device.attach(router, 501)
    client = client_of(router, 501)
    assert client.get(0x504D, 0x01, "<I") == 77
    assert client.get(0x504D, 0x09, "<d") == 90.0
    assert client.get(0x4001, 0x11_0009, "<d") == 90.0
    assert client.get(0x4001, 0x01_0009, "<d") == 360.0
    client.put(0x4001, 0x11_0009, "<d", 45.0)
    assert client.get(0x504D, 0x09, "<d") == 45.0
    assert (client.get(0x5003, 0x01, "<I"), client.get(0x6005, 0x01, "<I")) == (3, 5)
    assert client.get(0x4002, 0x5A, "<27I") == (3, *[0] * 8, 5, *[0] * 8, 6, *[0] * 8)
    assert client.get(0x4001, 0x57, "<I") == 2
    assert client.get(0x1100, 0x34, "<3I") == (1, 77, 3)
    assert client.get(0x1100, 0x14D, "<I") == 1
    assert client.get(0x1100, 0x105, "<I") == 0
    with refused(0x4013):
        client.get(0x4001, 0x21_0009, "<d")
    with refused(0x4014):
        client.get(0x4001, 0x12_0102, "<d")
    with refused(0x4013):
        client.get(0x5002, 0x09, "<d")
