"""`achse monitor`: what passes, live, from a station of ours or in front of any target."""

import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.cli.record.monitor import lines_of
from achse.monitor.decode import Decoder
from achse.monitor.names import Names
from achse.router.tap import Captured
from achse.testing import LiveStation, free_host
from tests.warm_commands import PIPES, WarmCommands


@contextmanager
def running(
    commands: WarmCommands, *arguments: str, host: str
) -> Iterator[Callable[[], list[str]]]:
    """The command in a process of its own, ready; calling gives its lines once it has ended."""
    process = commands.popen(*arguments, "--host", host, **PIPES)
    assert process.stdout is not None
    ready = process.stdout.readline()
    assert ready.startswith(("achse ready ", '{"event": "ready"')), ready + process.communicate()[1]

    def ended() -> list[str]:
        out, errors = process.communicate()
        assert (process.returncode, errors) == (0, "")
        return out.splitlines()

    try:
        yield ended
    finally:
        process.kill()
        process.communicate()


def use(host: str) -> None:
    """What a client of ours does."""
    with achse.blocking.connect(host, watch_symbols=False) as plc:
        plc.write("GVL.nInt", 9)
        plc.read("GVL.nInt")


def test_a_station_is_watched_with_names(tmp_path: Path, warm_commands: WarmCommands) -> None:
    capture = tmp_path / "some.pcapng"
    with LiveStation() as station:
        arguments = ("monitor", "-n", "2", "--write", str(capture), "--name", "GVL.nInt")
        with running(warm_commands, *arguments, host=station.host) as ended:
            use(station.host)
            lines = ended()
        assert [line.split("  ")[2] for line in lines] == [
            "write GVL.nInt = 9",
            "read GVL.nInt = 9",
        ]
        assert station.run(lambda: station.station.router._watcher) is None
    assert capture.stat().st_size > 500


def test_json_filters_and_a_count(warm_commands: WarmCommands) -> None:
    with LiveStation() as station:
        arguments = ("monitor", "--json", "-n", "1", "--errors", "--device", "851", "--no-samples")
        with running(warm_commands, *arguments, host=station.host) as ended:
            station.fault("error", symbol="GVL.nInt", code=0x706, count=1)
            with pytest.raises(Exception, match="0x706"):
                use(station.host)
            [line] = ended()
    exchange = json.loads(line)
    assert (exchange["error"], exchange["command"]) == (0x706, "write")
    assert exchange["items"][0]["name"] == "GVL.nInt"


def test_a_tap_in_front_of_a_target(warm_commands: WarmCommands) -> None:
    host = free_host()
    with (
        LiveStation() as station,
        running(
            *(warm_commands, "monitor", "-n", "2", "--via", station.host, "--name", "GVL.*"),
            host=host,
        ) as ended,
    ):
        use(host)
        assert [line.split("  ")[2] for line in ended()] == [
            "write GVL.nInt = 9",
            "read GVL.nInt = 9",
        ]


def test_a_tap_that_may_query_the_target_knows_types_that_no_client_requested(
    warm_commands: WarmCommands,
) -> None:
    host = free_host()
    with (
        LiveStation() as station,
        running(
            warm_commands,
            *("monitor", "-n", "1", "--via", station.host, "--ask", f"{station.net_id}:851"),
            *("--name", "GVL.eColour"),
            host=host,
        ) as ended,
    ):
        with achse.blocking.connect(host, net_id=station.net_id) as plc:
            handle = int.from_bytes(plc.read_write_raw(0xF003, 0, 4, b"GVL.eColour"), "little")
            plc.read_raw(0xF005, handle, 2)
        assert [line.split("  ")[2] for line in ended()] == ["read GVL.eColour = GREEN"]


@pytest.mark.parametrize(
    ("arguments", "exit_code", "message"),
    [
        (("--ask", "5.1.2.3.1.1"), 2, "a station of ours is asked anyway"),
        (("--via", "127.0.0.1", "--ask", "here"), 2, "--ask"),
        (("--via", "127.0.0.1:x"), 2, "expected HOST[:PORT]"),
        (("--via", "127.0.0.1:1", "--ask", "5.1.2.3.1.1"), 1, "127.0.0.1:1"),
    ],
)
def test_what_cannot_be_requested_is_refused(
    cli: Callable[..., Any], arguments: tuple[str, ...], exit_code: int, message: str
) -> None:
    refusal = cli("monitor", *arguments, exit_code=exit_code)
    assert message in " ".join(refusal.stderr.replace("│", " ").split())


def test_what_is_no_station_of_ours_is_reported(warm_commands: WarmCommands) -> None:
    from achse.testing import FakeDevice

    with FakeDevice().serving() as live:
        run = warm_commands.run("monitor", "--host", live.host)
    assert run.returncode == 1
    assert "is not an achse station: tap in front of it with --via" in run.stderr


@pytest.mark.parametrize(
    "command", [("monitor",), ("monitor", "--quiet", "--write", "some.pcapng")]
)
def test_a_station_without_room_for_a_watcher_is_reported_as_such(
    tmp_path: Path, command: tuple[str, ...], warm_commands: WarmCommands
) -> None:
    config = tmp_path / "station.toml"
    config.write_text("[router]\nmax_connections = 1\n")
    with LiveStation(config) as station, station.connect(port=10_000) as only:
        only.state()
        run = warm_commands.run(*command, "--host", station.host, cwd=tmp_path)
    assert run.returncode == 1
    assert "0x508" in run.stderr


def test_an_unanswered_request_says_so() -> None:
    from achse.ams import AmsAddress, Frame

    client, plc = AmsAddress("10.0.0.7.1.1:30000"), AmsAddress("5.0.0.1.1.1:851")
    decoder = Decoder(Names({}))
    request = Frame(plc, client, 4, 4, 0, 1, b"")
    assert list(decoder.see(Captured(10**18, True, "10.0.0.7:5000", request.encode()))) == []
    [exchange] = decoder.overdue(10**18 + 1)
    clock = time.strftime("%H:%M:%S", time.localtime(10**9))
    assert lines_of(exchange) == [f"{clock}.000  10.0.0.7:5000 → 851  read state  ✗ no answer"]


def test_what_a_client_writes_stays_on_its_line() -> None:
    from achse.ams import AmsAddress, Frame
    from achse.ams.commands import ReadWriteRequest

    client, plc = AmsAddress("10.0.0.7.1.1:30000"), AmsAddress("5.0.0.1.1.1:851")
    request_data = ReadWriteRequest(0xF003, 0, 4, b"GVL.\x1b[2J\nx\0").encode()
    decoder = Decoder(Names({}))
    request = Frame(plc, client, 9, 4, 0, 1, request_data)
    assert list(decoder.see(Captured(10**18, True, "10.0.0.7:5000", request.encode()))) == []
    [exchange] = decoder.overdue(10**18 + 1)
    [line] = lines_of(exchange)
    assert line.isprintable()
    assert r"GVL.\x1b[2J\nx" in line
