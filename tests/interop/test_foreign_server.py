"""Our client and our monitor on a server by others: that of pyads, which serves less than a PLC.

It has symbol entries without NUL, no sums by handle, no port service, and reads one request per
TCP segment.
"""

import asyncio
import struct
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import achse
from achse.ams import AdsState, RequestTimeout
from achse.iec import UDINT
from tests.warm_commands import WarmCommands

pytestmark = pytest.mark.filterwarnings(
    # A request it does not know ends the server's thread.
    "ignore::pytest.PytestUnhandledThreadExceptionWarning"
)


@pytest.fixture
def foreign(witness: Callable[[str], None]) -> Iterator[Any]:
    """pyads' test server with a few variables, on a free port."""
    witness("pyads")
    from pyads import constants
    from pyads.testserver import AdsTestServer, AdvancedHandler, PLCVariable

    handler = AdvancedHandler()
    for name, value, adst, type_name in (
        ("MAIN.nCounter", 42, constants.ADST_UINT32, "UDINT"),
        ("MAIN.fValue", 1.5, constants.ADST_REAL64, "LREAL"),
        ("MAIN.aValues", struct.pack("<3h", 1, 2, 3), constants.ADST_INT16, "ARRAY [0..2] OF INT"),
        ("MAIN.sText", b"hello\0\0\0", constants.ADST_STRING, "STRING(7)"),
    ):
        handler.add_variable(PLCVariable(name, value, adst, type_name))
    server = AdsTestServer(handler=handler, port=0, logging=False)
    server.port = server.server.getsockname()[1]
    server.server.listen()  # its thread does so too late for us
    with server:
        yield server


def connect(server: Any, **options: Any) -> Any:
    return achse.connect(f"127.0.0.1:{server.port}", watch_symbols=False, **options)


def test_values_by_name_and_by_place(foreign: Any) -> None:
    async def main() -> None:
        async with connect(foreign) as plc:
            assert (await plc.device_info()).name == "TestServer"
            assert (await plc.state()).ads_state is AdsState.RUN
            new = {"MAIN.nCounter": 7, "MAIN.fValue": -2.5, "MAIN.aValues": [4, 5, 6]}
            assert await plc.read("MAIN.sText") == "hello"
            for name, value in new.items():
                assert await plc.read(name) != value
                await plc.write(name, value)
                assert await plc.read(name) == value
            variable = foreign.handler.get_variable_by_name("MAIN.nCounter")
            assert await plc.read_as(variable.index_group, variable.index_offset, UDINT) == 7

    asyncio.run(main())


def test_a_question_it_dies_of_is_a_time_out(foreign: Any) -> None:
    async def main() -> None:
        async with connect(foreign, mode="direct", timeout=0.5) as plc:
            with pytest.raises(RequestTimeout, match=r"MAIN\.none"):
                await plc.read("MAIN.none")

    asyncio.run(main())


def test_the_monitor_between_a_client_and_a_target_of_others(
    foreign: Any,
    free_host: Callable[[], str],
    warm_commands: WarmCommands,
    witness: Callable[[str], None],
    tmp_path: Path,
) -> None:
    witness("tshark")
    import pyads

    host, capture = free_host(), tmp_path / "session.pcapng"
    way = ("--via", f"127.0.0.1:{foreign.port}", "--host", host)
    with warm_commands.popen(
        "monitor", *way, "--write", str(capture), stdout=subprocess.PIPE
    ) as monitor:
        assert monitor.stdout is not None
        assert monitor.stdout.readline().startswith(f"achse ready tap={host}:48898")
        with pyads.Connection("127.0.0.1.1.1", 851, host) as plc:
            plc.write_by_name("MAIN.nCounter", 7, pyads.PLCTYPE_UDINT)
            assert plc.read_by_name("MAIN.nCounter", pyads.PLCTYPE_UDINT) == 7
        monitor.terminate()
        shown = monitor.communicate()[0].splitlines()
    assert [line.split("  ")[2] for line in shown if "handle" not in line] == [
        "write MAIN.nCounter = 07 00 00 00",
        "read MAIN.nCounter = 07 00 00 00",
    ]
    fields = ("-T", "fields", "-e", "ams.cmdid", "-e", "_ws.malformed")
    read = ["tshark", "-r", str(capture), "-Y", "ams", *fields]
    seen = subprocess.run(read, capture_output=True, text=True, check=True).stdout.splitlines()
    assert len(seen) == 2 * len(shown)
    assert not any("malformed" in line.lower() for line in seen)
