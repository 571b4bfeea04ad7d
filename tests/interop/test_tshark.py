"""tshark finds nothing malformed in what pyads and ads-client exchange with the station."""

import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

REQUEST, RESPONSE = 0x0004, 0x0005
NOTIFICATION = 8


def tshark(capture: Path, display_filter: str, *fields: str) -> list[list[str]]:
    """The fields of all frames that pass the filter."""
    columns = [argument for field in fields for argument in ("-e", field)]
    finished = subprocess.run(
        ["tshark", "-r", str(capture), "-Y", display_filter, "-T", "fields", *columns],
        capture_output=True,
        text=True,
        check=True,
    )
    return [line.split("\t") for line in finished.stdout.splitlines()]


def invoke_ids(capture: Path, flags: int) -> list[int]:
    """The invoke ids of all frames with these state flags but notifications, which have none."""
    frames = tshark(capture, "ams", "ams.stateflags", "ams.cmdid", "ams.invokeid")
    return sorted(
        int(number, 0)
        for kind, command, number in frames
        if int(kind, 0) == flags and int(command, 0) != NOTIFICATION
    )


@pytest.fixture
def judge(witness: Callable[[str], None], tap: Any, tmp_path: Path) -> Callable[[], None]:
    """`judge()` ends the capture and lets tshark read it."""
    witness("tshark")

    def read() -> None:
        capture = tmp_path / "session.pcap"
        tap.write(capture)
        assert tshark(capture, "_ws.malformed", "frame.number") == []
        requests, answered = invoke_ids(capture, REQUEST), invoke_ids(capture, RESPONSE)
        assert len(requests) > 10
        assert requests == answered
        assert tshark(capture, "ams.errorcode != 0", "frame.number") == []

    return read


def test_a_session_of_pyads(
    station: Any, tap: Any, pyads_connection: Callable[..., Any], judge: Callable[[], None]
) -> None:
    plc = pyads_connection(station, 851, host=tap.host)
    plc.read_device_info()
    plc.read_state()
    for _ in range(10):
        plc.read_by_name("MAIN.nCounter")
    plc.write_list_by_name({f"GVL.aInt[{index}]": index for index in range(10)})
    handles = plc.add_device_notification("MAIN.nCounter", _attributes(), lambda *_: None)
    plc.get_all_symbols()
    plc.del_device_notification(*handles)
    judge()


def _attributes() -> Any:
    import pyads

    return pyads.NotificationAttrib(4)


@pytest.mark.parametrize("mode", ["router", "direct"])
def test_a_session_of_ads_client(
    station: Any, tap: Any, node: Callable[..., Any], judge: Callable[[], None], mode: str
) -> None:
    node("variables.mjs", station, mode, host=tap.host)
    judge()
