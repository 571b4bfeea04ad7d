"""The PLC device as a whole: info, states, notifications, error codes."""

import struct

import pytest

from achse.ams import AdsState, AmsAddress, Command, Frame, NetId
from achse.ams.commands import (
    AddNotificationRequest,
    ReadRequest,
    ReadWriteRequest,
    WriteControlRequest,
)
from achse.ams.notification import NotificationStream
from achse.codes import ReturnCode
from achse.devices.plc import PlcDevice
from achse.plc import PlcRuntime
from achse.router import Router

MS = 1_000_000


class Client:
    """A local port that asks the device and keeps what comes back."""

    def __init__(self, device: PlcDevice) -> None:
        self.router = Router(NetId("5.1.2.3.1.1"))
        self.target = device.attach(self.router, 851)
        self.frames: list[Frame] = []
        self.address = self.router.register(0, self)

    def deliver(self, frame: Frame) -> bool:
        self.frames.append(frame)
        return True

    def ask(self, command: Command, data: bytes = b"") -> bytes:
        self.frames.clear()
        self.router.deliver(Frame(self.target, self.address, command, data=data, invoke_id=1))
        return self.frames[0].data

    def result(self, command: Command, data: bytes = b"") -> ReturnCode | None:
        return ReturnCode.of(struct.unpack_from("<I", self.ask(command, data))[0])

    def samples(self) -> list[bytes]:
        return [
            sample.data
            for frame in self.frames
            if frame.command == Command.NOTIFICATION
            for stamp in NotificationStream.decode(frame.data).stamps
            for sample in stamp.samples
        ]


@pytest.fixture
def client(device: PlcDevice) -> Client:
    return Client(device)


def test_it_is_the_plc_application_of_a_real_target(client: Client) -> None:
    assert client.ask(Command.READ_DEVICE_INFO) == bytes.fromhex(
        "00000000 03 01 b80f 506c6333302041707000000000000000"
    )


def control(client: Client, state: int) -> ReturnCode | None:
    return client.result(Command.WRITE_CONTROL, WriteControlRequest(state, 0, b"\0").encode())


def state(client: Client) -> tuple[int, int]:
    ads_state, device_state = struct.unpack("<4xHH", client.ask(Command.READ_STATE))
    return ads_state, device_state


def test_write_control_stops_runs_and_resets(client: Client, plc: PlcRuntime) -> None:
    plc.run_due(50 * MS)
    assert state(client) == (AdsState.RUN, 0)
    assert control(client, AdsState.STOP) is ReturnCode.NO_ERROR
    assert state(client) == (AdsState.STOP, 0)
    counter = client_value(client, b"MAIN.nCounter")
    plc.run_due(100 * MS)
    assert client_value(client, b"MAIN.nCounter") == counter == 5
    assert control(client, AdsState.RUN) is ReturnCode.NO_ERROR
    plc.run_due(110 * MS)
    assert client_value(client, b"MAIN.nCounter") == 6
    assert control(client, AdsState.RESET) is ReturnCode.NO_ERROR
    assert state(client) == (AdsState.STOP, 0)
    assert client_value(client, b"MAIN.nCounter") == 0


def test_reset_ends_abandoned_handles_and_online_change_puts_them_out_of_date(
    client: Client, plc: PlcRuntime, device: PlcDevice
) -> None:
    def handle() -> int:
        request = ReadWriteRequest(0xF003, 0, 4, b"MAIN.nCounter")
        return int(struct.unpack("<8xI", client.ask(Command.READ_WRITE, request.encode()))[0])

    def codes(*handles: int) -> list[int]:
        requests = [ReadRequest(0xF005, each, 4).encode() for each in handles]
        return [struct.unpack_from("<I", client.ask(Command.READ, each))[0] for each in requests]

    abandoned = handle()
    device.end_client(client.address)
    own = handle()
    plc.stop()
    plc.run()
    assert codes(own, abandoned) == [0, 0]
    plc.online_change()
    new = handle()
    assert codes(own, abandoned, new) == [0x711, 0x711, 0]
    plc.reset()
    assert codes(own, abandoned, new) == [0x711, 0x710, 0]


def client_value(client: Client, name: bytes) -> int:
    request = ReadWriteRequest(0xF004, 0, 4, name)
    answer = client.ask(Command.READ_WRITE, request.encode())
    result, length, value = struct.unpack("<III", answer)
    assert (result, length) == (0, 4)
    return int(value)


@pytest.mark.parametrize(
    ("wanted", "code"),
    [
        (0, ReturnCode.SERVICE_NOT_SUPPORTED),
        (20, ReturnCode.SERVICE_NOT_SUPPORTED),
        (0xFFFF, ReturnCode.SERVICE_NOT_SUPPORTED),
        (AdsState.CONFIG, ReturnCode.INVALID_STATE),
    ],
)
def test_other_states_are_refused(client: Client, wanted: int, code: ReturnCode) -> None:
    assert control(client, wanted) is code
    assert state(client) == (AdsState.RUN, 0)


def test_a_program_error_shows_as_exception_until_a_reset(
    client: Client, plc: PlcRuntime, device: PlcDevice
) -> None:
    handle = device.read_write(0xF003, 0, 4, b"MAIN.nFaultAt")
    device.write(0xF005, struct.unpack("<I", handle)[0], b"\x03\0\0\0")
    plc.run_due(100 * MS)
    assert state(client) == (AdsState.EXCEPTION, 0)
    assert client_value(client, b"MAIN.nCounter") == 3
    assert control(client, AdsState.RUN) is ReturnCode.INVALID_STATE
    assert control(client, AdsState.RESET) is ReturnCode.NO_ERROR
    assert control(client, AdsState.RUN) is ReturnCode.NO_ERROR
    assert state(client) == (AdsState.RUN, 0)


def test_the_state_is_readable_as_a_value_and_as_the_system_state(
    client: Client, device: PlcDevice, plc: PlcRuntime
) -> None:
    plc.reset()
    assert device.read(0xF100, 0, 4) == struct.pack("<HH", AdsState.STOP, 0)
    assert device.read(0xF0, 0, 16) == struct.pack(
        "<HHHBBHBBHH", AdsState.STOP, 0, 1, 3, 1, 4024, 1, 0, 0, 0
    )


@pytest.mark.parametrize(
    "request_",
    [ReadRequest(0, 0, 4), ReadRequest(0x4025, 0x1_0000, 4), ReadRequest(0x1234_5678, 0, 4)],
)
def test_unknown_services_answer_0x701_alone_and_0x702_in_a_sum(
    client: Client, device: PlcDevice, request_: ReadRequest
) -> None:
    assert client.result(Command.READ, request_.encode()) is ReturnCode.SERVICE_NOT_SUPPORTED
    if request_.index_group != 0x4025:
        result = device.read_write(0xF080, 1, 8, request_.encode())
        assert struct.unpack_from("<I", result) == (ReturnCode.INVALID_GROUP.number,)
    watch = AddNotificationRequest(request_.index_group, request_.index_offset, 4, 4, 0, 0)
    assert (
        client.result(Command.ADD_NOTIFICATION, watch.encode()) is ReturnCode.SERVICE_NOT_SUPPORTED
    )


def run(device: PlcDevice, plc: PlcRuntime, clock: list[int], milliseconds: int) -> None:
    for _ in range(milliseconds):
        clock[0] += MS
        plc.run_due(clock[0] - 1_700_000_000_000_000_000)
        device.notifications.tick(clock[0])


def test_a_counter_is_seen_once_per_cycle(
    client: Client, device: PlcDevice, plc: PlcRuntime, clock: list[int]
) -> None:
    handle = struct.unpack("<I", device.read_write(0xF003, 0, 4, b"MAIN.nCounter", client.address))
    watch = AddNotificationRequest(0xF005, handle[0], 4, 4, 0, 100_000)
    client.ask(Command.ADD_NOTIFICATION, watch.encode())
    run(device, plc, clock, 100)
    assert client.samples() == [struct.pack("<I", count) for count in range(11)]


def test_a_subscriber_of_the_state_sees_it_change(
    client: Client, device: PlcDevice, plc: PlcRuntime, clock: list[int]
) -> None:
    watch = AddNotificationRequest(0xF100, 0, 4, 4, 0, 0)
    client.ask(Command.ADD_NOTIFICATION, watch.encode())
    run(device, plc, clock, 20)
    plc.stop()
    run(device, plc, clock, 20)
    assert client.samples() == [
        struct.pack("<HH", AdsState.RUN, 0),
        struct.pack("<HH", AdsState.STOP, 0),
    ]


def test_each_context_has_the_cycle_of_its_task(device: PlcDevice) -> None:
    assert [device.task_cycle(context) for context in (0, 1, 2, 3)] == [
        10 * MS,
        10 * MS,
        100 * MS,
        10 * MS,
    ]


def test_it_answers_on_several_ports(device: PlcDevice, client: Client) -> None:
    address = device.attach(client.router, 801)
    assert address == AmsAddress.of(NetId("5.1.2.3.1.1"), 801)
    client.target = address
    assert state(client) == (AdsState.RUN, 0)


def test_all_documented_groups_are_there_each_row_once(device: PlcDevice) -> None:
    rows = list(device.services.describe())
    assert len({(row.index_group, row.index_offset) for row in rows}) == len(rows)
    documented = {
        *(0x4020, 0x4021, 0x4025, 0x4030, 0x4035, 0x4040, 0x4045),
        *(0xF003, 0xF004, 0xF005, 0xF006),
        *(0xF020, 0xF021, 0xF025, 0xF030, 0xF031, 0xF035, 0xF040, 0xF050),
        *range(0xF080, 0xF087),
    }
    assert documented <= {row.index_group for row in rows}
