"""The NC device: ids, groups, ports, and its rows against the list of the manual's services."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from achse.ams import AmsAddress, Command, Frame
from achse.ams.commands import EmptyRequest
from achse.codes import NcError
from achse.devices.nc.device import AXIS_GROUPS

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
    assert unknown == []


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


@pytest.mark.parametrize("group", [0x0FFF, 0x1001, 0x2001, 0x4400, 0x8000])
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
    pytest.importorskip("numba")
    from achse.motion.axis import ObjectAxis, WordsAxis

    fields = {row.field for _, rows, _ in AXIS_GROUPS for row in rows if row.field}
    assert all(hasattr(ObjectAxis, field) and hasattr(WordsAxis, field) for field in fields)


def test_what_happens_to_an_axis_is_notified(bench: Any) -> None:
    bench.client.subscribe(0x4101, 0x0A, 8, cycle_s=0.01)
    bench.start(10.0, 100.0)
    for _ in range(50):
        bench.run(0.002)
        bench.device.notify(bench.nc.cycle_count * 2_000_000)
    samples = bench.client.samples()
    assert len(samples) == pytest.approx(11, abs=1)
    assert len({data for _, data in samples}) >= 10
