"""Our client on a server by others: the test server of pyads, which serves less than a PLC.

It has symbol entries without NUL, no sums by handle, no port service, and reads one request per
TCP segment.
"""

import asyncio
import struct
from collections.abc import Callable, Iterator
from typing import Any

import pytest

import achse
from achse.ams import AdsState, RequestTimeout
from achse.iec import UDINT

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
