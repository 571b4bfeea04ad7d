"""File services: both forms, modes, positions, handles of clients, what is refused."""

import asyncio
import os
import struct
import threading
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import achse
from achse.ams import DeviceError, NetId
from achse.devices.system import SystemDevice
from achse.devices.system.files import FIND_ENTRY, OpenMode
from achse.devices.system.folder import Folder
from achse.router import Router

READ, WRITE, APPEND, PLUS = OpenMode.READ, OpenMode.WRITE, OpenMode.APPEND, OpenMode.PLUS
BINARY, TEXT, ENSURE = OpenMode.BINARY, OpenMode.TEXT, OpenMode.ENSURE_FOLDER
GENERIC = 1 << 16
NO_SEEK = 0xFFFF_FFFF


def opened(client: Any, name: bytes, mode: int) -> int:
    (handle,) = struct.unpack("<I", client.exchange(120, mode, 4, name))
    return int(handle)


def read(client: Any, handle: int, length: int = 0xFFFF) -> bytes:
    return bytes(client.exchange(122, handle, length, b""))


def close(client: Any, handle: int) -> None:
    client.exchange(121, handle, 0, b"")


# today's form


def test_a_file_is_read_in_pieces_and_to_its_end(client: Any) -> None:
    handle = opened(client, b"a.txt\0", READ | BINARY | GENERIC)
    assert read(client, handle, 5) == b"first"
    assert client.exchange(130, handle, 4, b"") == b"\0\0\0\0"
    assert read(client, handle, 0xFFFF_FFFF) == b"\r\nsecond\n"
    assert client.exchange(130, handle, 4, b"") == b"\1\0\0\0"
    assert read(client, handle) == b""


def test_a_file_is_written_appended_and_updated(client: Any, root: Path) -> None:
    handle = opened(client, b"new.bin", WRITE)
    client.exchange(123, handle, 0, b"abc")
    client.exchange(123, handle, 0, b"def")
    close(client, handle)
    handle = opened(client, b"new.bin", APPEND)
    client.exchange(123, handle, 0, b"ghi")
    close(client, handle)
    handle = opened(client, b"new.bin", READ | PLUS)
    client.exchange(124, handle, 0, struct.pack("<iI", 3, 0))
    client.exchange(123, handle, 0, b"DEF")
    assert read(client, handle) == b"ghi"
    assert (root / "new.bin").read_bytes() == b"abcDEFghi"


@pytest.mark.parametrize(
    ("origin", "position", "expected"), [(0, 2, 2), (1, 2, 7), (2, -3, 11), (2, 10, 24)]
)
def test_seek_and_tell(client: Any, origin: int, position: int, expected: int) -> None:
    handle = opened(client, b"a.txt", READ)
    read(client, handle, 5)
    client.exchange(124, handle, 0, struct.pack("<iI", position, origin))
    assert struct.unpack("<i", client.exchange(125, handle, 4, b"")) == (expected,)


@pytest.mark.parametrize(
    ("data", "code"),
    [(struct.pack("<iI", -1, 0), 0x70B), (struct.pack("<iI", 0, 3), 0x70B), (bytes(4), 0x705)],
)
def test_a_seek_that_cannot_be(client: Any, refused: Any, data: bytes, code: int) -> None:
    handle = opened(client, b"a.txt", READ)
    with refused(code):
        client.exchange(124, handle, 0, data)


def test_lines_and_texts(client: Any, root: Path) -> None:
    handle = opened(client, b"a.txt", READ | TEXT)
    assert client.exchange(126, handle, 4, b"") == b"fir\0"
    assert client.exchange(126, handle, 255, b"") == b"st\r\n\0"
    assert client.exchange(126, handle, 255, b"") == b"second\n\0"
    assert client.exchange(126, handle, 255, b"") == b""
    handle = opened(client, b"b.txt", WRITE | TEXT)
    client.exchange(127, handle, 0, b"line\n\0rest of a buffer")
    assert (root / "b.txt").read_bytes() == b"line\n"


def test_missing_folders_are_made_where_requested(client: Any, refused: Any, root: Path) -> None:
    with refused(0x70C):
        opened(client, b"x/y/z", WRITE)
    opened(client, b"x/y/z", WRITE | ENSURE)
    assert (root / "x" / "y" / "z").is_file()


@pytest.mark.parametrize("mode", [0, READ | WRITE, BINARY, READ | BINARY | TEXT, READ | 0x100])
def test_modes_that_are_none(client: Any, refused: Any, mode: int) -> None:
    with refused(0x703):
        opened(client, b"a.txt", mode)


def test_what_cannot_be_opened(client: Any, refused: Any, root: Path) -> None:
    (root / "sub").mkdir()
    os.mkfifo(root / "pipe")
    for name in (b"none", b"sub", b"pipe", b"../secret.txt", b"a.txt/x"):
        with refused(0x70C):
            opened(client, name, READ)
    with refused(0x703):
        opened(client, b"a.txt", READ | 99 << 16)


def test_a_file_does_only_what_it_was_opened_for(client: Any, refused: Any) -> None:
    reading, writing = opened(client, b"a.txt", READ), opened(client, b"b", WRITE)
    with refused(0x70E):
        client.exchange(123, reading, 0, b"x")
    with refused(0x70E):
        read(client, writing)


def test_a_file_does_not_grow_without_end(client: Any, refused: Any) -> None:
    handle = opened(client, b"b", WRITE)
    client.exchange(124, handle, 0, struct.pack("<iI", 0x4000_0000, 0))
    with refused(0x70A):
        client.exchange(123, handle, 0, b"x")


# the older form


def test_create_write_seek_read_close_as_the_manual_has_it(client: Any, root: Path) -> None:
    (handle,) = struct.unpack("<I", client.exchange(100, 1, 4, b"old.dat"))
    client.write(handle, NO_SEEK, b"0123456789")
    client.write(handle, 2, b"xy")
    assert client.read(handle, 0, 4) == b"01xy"
    assert client.read(handle, NO_SEEK, 2) == b"45"
    assert client.read(handle, 8, 0) == b""
    assert client.read(handle, NO_SEEK, 100) == b"89"
    client.write(handle, NO_SEEK, b"")
    assert (root / "old.dat").read_bytes() == b"01xy456789"


def test_by_read_write_writing_answers_how_many_bytes(
    client: Any, refused: Any, root: Path
) -> None:
    (handle,) = struct.unpack("<I", client.exchange(100, 1, 4, b"old.dat"))
    assert client.exchange(handle, NO_SEEK, 4, b"0123456789") == b"\x0a\0\0\0"
    assert client.exchange(handle, 2, 4, b"xy") == b"\2\0\0\0"
    assert client.exchange(handle, NO_SEEK, 4, b"") == bytes(4)  # closed
    assert (root / "old.dat").read_bytes() == b"01xy456789"
    with refused(0x70C):
        client.exchange(handle, NO_SEEK, 4, b"x")
    (handle,) = struct.unpack("<I", client.exchange(101, 1, 4, b"a.txt"))
    assert client.exchange(handle, NO_SEEK, 4, b"x") == b"\xff\xff\xff\xff"


def test_101_and_102_give_minus_one_for_a_missing_file(client: Any, root: Path) -> None:
    assert client.exchange(101, 1, 4, b"none") == b"\xff\xff\xff\xff"
    assert client.exchange(102, 1, 4, b"none") == b"\xff\xff\xff\xff"
    assert client.exchange(101, 1, 4, b"../secret.txt") == b"\xff\xff\xff\xff"
    assert not (root / "none").exists()


def test_102_empties_the_file_101_only_reads(client: Any, refused: Any, root: Path) -> None:
    (handle,) = struct.unpack("<I", client.exchange(101, 1, 4, b"a.txt"))
    with refused(0x70E):
        client.write(handle, NO_SEEK, b"x")
    (handle,) = struct.unpack("<I", client.exchange(102, 1, 4, b"a.txt"))
    assert (root / "a.txt").read_bytes() == b""
    client.write(handle, NO_SEEK, b"x")
    assert read(client, handle) == b""


def test_a_plain_write_cannot_open(client: Any, refused: Any) -> None:
    with refused(0x704):
        client.write(100, 1, b"x")


# names


def test_delete_rename_and_folders(client: Any, refused: Any, root: Path) -> None:
    client.exchange(138, 1, 0, b"sub\0")
    with refused(0x70F):
        client.exchange(138, 1, 0, b"sub\0")
    client.exchange(132, GENERIC, 0, b"a.txt\0sub/b.txt\0")
    assert (root / "sub" / "b.txt").exists()
    with refused(0x70F):
        client.exchange(139, 1, 0, b"sub")
    with refused(0x70C):
        client.exchange(131, GENERIC, 0, b"sub")
    client.exchange(131, GENERIC, 0, b"sub\\b.txt")
    client.exchange(131, GENERIC | OpenMode.ENABLE_FOLDER, 0, b"sub")
    assert list(root.iterdir()) == []
    with refused(0x70C):
        client.exchange(131, GENERIC, 0, b"a.txt")
    with refused(0x705):
        client.exchange(132, GENERIC, 0, b"a.txt")


def test_rename_replaces_nothing(client: Any, refused: Any, root: Path) -> None:
    (root / "b").write_text("b")
    with refused(0x70F):
        client.exchange(132, GENERIC, 0, b"a.txt\0b\0")
    with refused(0x70C):
        client.exchange(132, GENERIC, 0, b"a.txt\0../b\0")


def test_files_are_opened_found_renamed_and_deleted_whatever_the_case(
    client: Any, refused: Any, root: Path
) -> None:
    handle = int.from_bytes(client.exchange(120, GENERIC | OpenMode.WRITE, 4, b"A.TXT"), "little")
    client.exchange(121, handle, 0, b"")
    assert [path.name for path in root.iterdir()] == ["a.txt"]
    assert client.exchange(133, 1, 324, b"A.TXT")[48:54] == b"a.txt\0"
    client.exchange(132, GENERIC, 0, b"A.TXT\0A.Txt\0")
    assert [path.name for path in root.iterdir()] == ["A.Txt"]
    with refused(0x70F):
        client.exchange(132, GENERIC, 0, b"a.txt\0A.Txt\0")
    with refused(0x70F):
        client.exchange(138, 1, 0, b"a.TXT")
    client.exchange(131, GENERIC, 0, b"a.TXT")
    assert list(root.iterdir()) == []


def test_a_link_is_deleted_whatever_the_case(client: Any, root: Path) -> None:
    (root / "out").symlink_to(root.parent / "secret.txt")
    client.exchange(131, GENERIC, 0, b"OUT")
    assert (root.parent / "secret.txt").exists()
    assert not (root / "out").is_symlink()


def test_a_link_is_deleted_not_what_it_leads_to(client: Any, root: Path) -> None:
    (root / "out").symlink_to(root.parent / "secret.txt")
    client.exchange(131, GENERIC, 0, b"out")
    assert (root.parent / "secret.txt").exists()
    assert not (root / "out").is_symlink()


def test_find_reports_one_entry_per_request(client: Any, refused: Any, root: Path) -> None:
    (root / "sub").mkdir()
    os.utime(root / "a.txt", ns=(0, 0))
    data = client.exchange(133, 1, 324, b"*")
    assert len(data) == FIND_ENTRY.size == 324
    handle, attributes, _, _, written, high, low, name = FIND_ENTRY.unpack(data)
    assert (attributes, high, low, name.rstrip(b"\0")) == (0x20, 0, 14, b"a.txt")
    assert written == 116_444_736_000_000_000
    assert data[48:54] == b"a.txt\0"
    _, attributes, *_, name = FIND_ENTRY.unpack(client.exchange(133, handle, 324, b""))
    assert (attributes, name.rstrip(b"\0")) == (0x10, b"sub")
    with refused(0x70C):
        client.exchange(133, handle, 324, b"")
    with refused(0x70C):
        client.exchange(133, handle, 324, b"")
    with refused(0x70C):
        client.exchange(133, 1, 324, b"none")


def test_a_search_can_be_given_up(client: Any, device: SystemDevice, refused: Any) -> None:
    (handle,) = struct.unpack_from("<I", client.exchange(133, 1, 324, b"*"))
    client.write(111, 0, struct.pack("<I", handle))
    assert len(device.files) == 0
    with refused(0x70C):
        client.write(111, 0, struct.pack("<I", handle))
    with refused(0x705):
        client.write(111, 0, b"")


def test_a_search_that_has_too_much_to_report_is_refused(
    client: Any, refused: Any, root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number in range(5):
        (root / f"{number}.txt").touch()
    monkeypatch.setattr("achse.devices.system.files._MOST_MATCHES", 10)
    client.exchange(133, 1, 324, b"*")
    with refused(0x70A):
        client.exchange(133, 1, 324, b"*")


def test_an_open_file_is_not_watched(client: Any, refused: Any) -> None:
    handle = opened(client, b"a.txt", READ)
    with refused(0x701):
        client.subscribe(handle, 0, 1)


# beside the loop


async def test_no_file_service_holds_the_loop(
    device: SystemDevice, router: Router, root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever the disk takes, others are answered; before, 30,000 files took 2.4 s of all."""
    let_go = threading.Event()
    matching = Folder.matching

    def slow(folder: Folder, pattern: bytes, place: int) -> tuple[Path, list[str]]:
        assert let_go.wait(60)
        return matching(folder, pattern, place)

    monkeypatch.setattr(Folder, "matching", slow)
    with device.files_beside(asyncio.get_running_loop()):
        async with (
            achse.connect(router, port=10_000) as one,
            achse.connect(router, port=10_000) as other,
        ):
            result = asyncio.create_task(one.read_write_raw(133, 1, 324, b"*"))
            for _ in range(20):
                assert (await other.state()).ads_state == 5
            assert not result.done()
            let_go.set()
            assert FIND_ENTRY.unpack(await result)[-1].rstrip(b"\0") == b"a.txt"


async def test_beside_the_loop_a_sum_of_file_services_is_refused(
    device: SystemDevice, router: Router
) -> None:
    part = struct.pack("<IIII", 120, READ, 4, 5) + b"a.txt"
    with device.files_beside(asyncio.get_running_loop()):
        async with achse.connect(router, port=10_000) as client:
            answer = await client.read_write_raw(0xF082, 1, 64, part)
    assert struct.unpack_from("<I", answer)[0] == 0x701
    assert len(device.files) == 0


async def test_beside_the_loop_files_end_with_their_client(
    device: SystemDevice, router: Router
) -> None:
    with device.files_beside(asyncio.get_running_loop()):
        async with achse.connect(router, port=10_000) as client:
            for _ in range(10):
                await client.read_write_raw(120, READ, 4, b"a.txt")
            assert len(device.files) == 10
        while len(device.files):  # noqa: ASYNC110
            await asyncio.sleep(0.001)


async def test_beside_the_loop_unused_files_are_closed(
    device: SystemDevice, router: Router, clock: Any
) -> None:
    with device.files_beside(asyncio.get_running_loop()):
        async with achse.connect(router, port=10_000) as client:
            await client.read_write_raw(120, READ, 4, b"a.txt")
            clock.now += 601_000_000_000
            device.sweep(clock.now)
            while len(device.files):  # noqa: ASYNC110
                await asyncio.sleep(0.001)


names = st.sampled_from([b"a.txt", b"b", b"B", b"sub/c", b"..", b"*", b"", b"sub"])
wishes = st.lists(
    st.tuples(
        st.sampled_from(
            [100, 101, 102, 120, 121, 122, 123, 124, 125, 126, 130, 131, 132, 133, 138]
        ),
        st.integers(0, 6),
        names,
        st.sampled_from([READ, WRITE, APPEND, WRITE | PLUS | ENSURE]),
    ),
    max_size=25,
)


@settings(max_examples=13)
@given(requested=wishes)
def test_beside_the_loop_answers_are_the_same(
    requested: list[tuple[int, int, bytes, int]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Any services in any order: answers, files and handles as without a thread."""

    def request(wish: tuple[int, int, bytes, int], handles: list[int]) -> tuple[int, int, bytes]:
        group, number, name, mode = wish
        if group in (120, 100, 101, 102):
            return group, (mode if group == 120 else 0) | GENERIC, name
        if group in (131, 132, 133, 138):
            return group, GENERIC, name + (b"\0d" if group == 132 else b"")
        offset = handles[number % len(handles)] if handles else 0xF600
        return group, offset, struct.pack("<iI", number, 0) if group == 124 else name

    async def run(beside: bool) -> list[object]:
        root = tmp_path_factory.mktemp("same") / "root"
        root.mkdir()
        (root / "a.txt").write_bytes(b"first\r\nsecond\n")
        router = Router(NetId("5.1.2.3.1.1"))
        device = SystemDevice(clock=lambda: 0, root=root)
        device.attach(router, 10_000)
        handles: list[int] = []
        reports: list[object] = []
        work = device.files_beside(asyncio.get_running_loop()) if beside else nullcontext()
        with work:
            async with achse.connect(router, port=10_000) as client:
                for wish in requested:
                    group, offset, data = request(wish, handles)
                    try:
                        answer = await client.read_write_raw(group, offset, 400, data)
                    except DeviceError as refusal:
                        reports.append((group, refusal.code))
                        continue
                    if group in (100, 101, 102, 120) and answer != b"\xff" * 4:
                        handles.append(int.from_bytes(answer, "little"))
                    reports.append((group, answer if group != 133 else answer[48:]))
        reports.append(sorted(str(path.relative_to(root)) for path in root.rglob("*")))
        device.files.close_all()
        return reports

    assert asyncio.run(run(True)) == asyncio.run(run(False))


# handles


def test_a_handle_is_its_clients_own_and_ends_with_it(
    device: SystemDevice, router: Router, client_of: Callable[..., Any], refused: Any
) -> None:
    one, other = client_of(router, 10_000), client_of(router, 10_000)
    handle = opened(one, b"a.txt", READ)
    with refused(0x70C):
        read(other, handle)
    with refused(0x70C):
        close(other, handle)
    router.unregister(one.address.port)
    assert len(device.files) == 0


def test_a_closed_handle_is_not_given_out_at_once(client: Any, refused: Any) -> None:
    first = opened(client, b"a.txt", READ)
    close(client, first)
    assert opened(client, b"a.txt", READ) != first
    with refused(0x70C):
        read(client, first)


def test_handles_of_a_client_are_limited(client: Any, refused: Any, device: SystemDevice) -> None:
    handles = [opened(client, b"a.txt", READ) for _ in range(64)]
    with refused(0x716):
        opened(client, b"a.txt", READ)
    assert 0 not in handles
    close(client, handles[0])
    opened(client, b"a.txt", READ)
    device.end_client(client.address)
    assert len(device.files) == 0


def test_handles_of_all_clients_are_limited(
    device: SystemDevice, router: Router, client_of: Callable[..., Any], refused: Any
) -> None:
    clients = [client_of(router, 10_000) for _ in range(5)]
    for client in clients[:4]:
        for _ in range(64):
            opened(client, b"a.txt", READ)
    with refused(0x716):
        opened(clients[4], b"a.txt", READ)
    for client in clients:
        device.end_client(client.address)


def test_unused_files_are_closed_after_ten_minutes(
    client: Any, device: SystemDevice, clock: Any, refused: Any
) -> None:
    used, unused = opened(client, b"a.txt", READ), opened(client, b"a.txt", READ)
    clock.now += 599_000_000_000
    read(client, used)
    clock.now += 2_000_000_000
    device.sweep(clock.now)
    read(client, used)
    with refused(0x70C):
        read(client, unused)


def test_without_a_folder_files_are_not_supported(
    client_of: Callable[..., Any], router: Router, refused: Any
) -> None:
    SystemDevice(clock=lambda: 0).attach(router, 10_000)
    client = client_of(router, 10_000)
    for group in (100, 101, 102, 120, 131, 133, 138):
        with refused(0x701):
            client.exchange(group, 1, 4, b"a.txt")


places = st.sampled_from([b"a.txt", b"..", b"sub", b"x/y", b"\\", b"/", b"C:", b"\0", b"*", b"out"])
requests = st.tuples(
    st.sampled_from([100, 101, 102, 111, *range(120, 140), *range(0xF600, 0xF604)]),
    st.sampled_from([0, 1, 2, 4, 9, 0x42, 0x82, 0x10002, 0x10082, 0x8000_0001, 0xFFFF_FFFF])
    | st.integers(0xF600, 0xF604),
    st.integers(0, 0xFFFF_FFFF),
    st.lists(places, max_size=4).map(b"/".join) | st.binary(max_size=12),
    st.sampled_from(["read", "write", "exchange"]),
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=75)
@given(st.lists(requests, max_size=12))
def test_any_request_stays_inside_and_is_answered(
    device: SystemDevice, client: Any, root: Path, requested: list[Any]
) -> None:
    """Nothing but documented codes, and nothing beside the folder is touched."""
    (root / "a.txt").write_bytes(b"again")
    if not (root / "out").is_symlink():
        (root / "out").symlink_to(root.parent)
    for group, offset, length, data, how in requested:
        code = 0
        try:
            if how == "read":
                client.read(group, offset, length)
            elif how == "write":
                client.write(group, offset, data)
            else:
                client.exchange(group, offset, length, data)
        except DeviceError as refusal:
            code = refusal.code
        assert code != 1, "an error of our own"
    assert sorted(path.name for path in root.parent.iterdir()) == ["root", "secret.txt"]
    assert (root.parent / "secret.txt").read_text() == "secret"
    device.files.close_all()
