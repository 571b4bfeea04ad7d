"""A PLC as server: programs answer requests of others, one after the other."""

import pytest

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.ams.commands import (
    DataResponse,
    ReadRequest,
    ReadWriteRequest,
    ResultResponse,
    WriteRequest,
)
from achse.devices.plc import PlcDevice, PlcRequests
from achse.plc.code.execution import CodeForm
from achse.plc.runtime import PlcState
from achse.router import Router
from tests.plc.code.conftest import Ran

HERE = NetId("5.1.2.3.1.1")
GROUP = 0x8000_0001

SERVER = """
VAR
    readInd : ADSREADIND; readRes : ADSREADRES; writeInd : ADSWRITEIND; writeRes : ADSWRITERES;
    bothInd : ADSRDWRTIND; bothRes : ADSRDWRTRES;
    kept : ARRAY [0..7] OF BYTE; pBytes : POINTER TO BYTE; i, sum : UDINT; n : INT;
    bAnswer : BOOL := TRUE;
END_VAR
"""
BODY = """
n := n + 1;
readInd(CLEAR := FALSE); readRes(RESPOND := FALSE);
IF readInd.VALID AND bAnswer THEN
    readRes(NETID := readInd.NETID, PORT := readInd.PORT, INVOKEID := readInd.INVOKEID,
        RESULT := SEL(readInd.IDXOFFS = 9, 0, 16#703), LEN := 8, DATAADDR := ADR(kept),
        RESPOND := TRUE);
    readInd(CLEAR := TRUE);
END_IF
writeInd(CLEAR := FALSE); writeRes(RESPOND := FALSE);
IF writeInd.VALID THEN
    MEMCPY(ADR(kept) + writeInd.IDXOFFS, writeInd.DATAADDR, writeInd.LENGTH);
    writeRes(NETID := writeInd.NETID, PORT := writeInd.PORT, INVOKEID := writeInd.INVOKEID,
        RESULT := 0, RESPOND := TRUE);
    writeInd(CLEAR := TRUE);
END_IF
bothInd(CLEAR := FALSE); bothRes(RESPOND := FALSE);
IF bothInd.VALID THEN
    sum := 0; pBytes := bothInd.DATAADDR;
    FOR i := 1 TO bothInd.WRTLENGTH DO sum := sum + pBytes^; pBytes := pBytes + 1; END_FOR
    bothRes(NETID := bothInd.NETID, PORT := bothInd.PORT, INVOKEID := bothInd.INVOKEID,
        RESULT := 0, LEN := MIN(bothInd.RDLENGTH, 4), DATAADDR := ADR(sum), RESPOND := TRUE);
    bothInd(CLEAR := TRUE);
END_IF
"""


class Client:
    """A port that asks the PLC and keeps what it is answered."""

    def __init__(self, ran: Ran, requests: PlcRequests) -> None:
        self.ran = ran
        self.router = Router(HERE)
        device = PlcDevice(ran.plc, clock=lambda: 0, requests=requests)
        self.server = device.attach(self.router, 851)
        self.answers: dict[int, bytes] = {}
        self.router.register(1000, self)

    def deliver(self, frame: Frame) -> bool:
        assert frame.error == 0
        self.answers[frame.invoke_id] = frame.data
        return True

    def ask(self, invoke_id: int, request: ReadRequest | WriteRequest | ReadWriteRequest) -> None:
        commands = {
            ReadRequest: Command.READ,
            WriteRequest: Command.WRITE,
            ReadWriteRequest: Command.READ_WRITE,
        }
        self.router.deliver(
            Frame(
                self.server,
                AmsAddress.of(HERE, 1000),
                commands[type(request)],
                invoke_id=invoke_id,
                data=request.encode(),
            )
        )

    def cycles(self, count: int = 1) -> None:
        self.ran.cycle(count)
        assert self.ran.plc.failure == ""

    def data(self, invoke_id: int) -> tuple[int, bytes]:
        decoded = DataResponse.decode(self.answers.pop(invoke_id))
        return decoded.result, decoded.data


@pytest.fixture(params=[CodeForm.PLAIN, CodeForm.AUTO])
def client(request: pytest.FixtureRequest) -> Client:
    requests = PlcRequests(lambda: 0)
    program = f"PROGRAM MAIN\n{SERVER}{BODY}END_PROGRAM"
    return Client(Ran(program, request.param, services=requests), requests)


def test_a_program_answers_each_service(client: Client) -> None:
    client.ask(1, WriteRequest(GROUP, 2, b"\1\2\3"))
    client.ask(2, ReadRequest(GROUP, 0, 6))
    client.ask(3, ReadWriteRequest(GROUP, 0, 100, b"\x10\x20"))
    assert client.answers == {}, "before a cycle"
    client.cycles()
    assert ResultResponse.decode(client.answers.pop(1)).result == 0
    assert client.data(2) == (0, bytes(6))
    assert client.data(3) == (0, b"\x30\0\0\0")
    client.ask(4, ReadRequest(GROUP, 0, 0xFFFF_FFFF))
    client.cycles(2)
    assert client.data(4) == (0, b"\0\0\1\2\3\0\0\0")
    client.ask(5, ReadRequest(GROUP, 9, 4))
    client.cycles(2)
    assert client.data(5)[0] == 0x703, "the program's own result"
    assert client.ran.plc.bodies is not None
    assert client.ran.plc.bodies.execution is not None
    assert client.ran.plc.bodies.execution.heap.used == 0, "data goes with CLEAR"


def test_ten_requests_wait_and_further_ones_are_refused(client: Client) -> None:
    client.ran.plc.instance("MAIN")["bAnswer"] = False
    for number in range(1, 13):
        client.ask(number, ReadRequest(GROUP, 0, 1))
    client.cycles(3)
    assert sorted(client.answers) == [11, 12]
    assert client.data(11) == client.data(12) == (0x716, b"")
    client.ran.plc.instance("MAIN")["bAnswer"] = True
    client.cycles(24)
    assert sorted(client.answers) == list(range(1, 11)), "one after the other"


@pytest.mark.parametrize("way", ["stop", "reset"])
def test_a_plc_that_stands_still_leaves_no_client_waiting(client: Client, way: str) -> None:
    client.ran.plc.instance("MAIN")["bAnswer"] = False
    client.ask(1, ReadRequest(GROUP, 0, 1))
    client.cycles()
    getattr(client.ran.plc, way)()
    assert client.data(1)[0] == 0x712
    client.ask(2, ReadRequest(GROUP, 0, 1))
    assert client.data(2)[0] != 0, "nobody takes it"
    assert client.ran.plc.state is PlcState.STOP


def test_other_groups_and_broken_requests_are_the_device_s(client: Client) -> None:
    client.ask(1, ReadRequest(0x8100_0000, 0, 1))
    client.ask(2, ReadRequest(0x4020, 0, 2))
    assert client.data(1)[0] != 0
    assert client.data(2) == (0, b"\0\0")
    frame = Frame(
        client.server, AmsAddress.of(HERE, 1000), Command.WRITE, invoke_id=3,
        data=GROUP.to_bytes(4, "little"),
    )  # fmt: skip
    client.router.deliver(frame)
    assert ResultResponse.decode(client.answers.pop(3)).result != 0
