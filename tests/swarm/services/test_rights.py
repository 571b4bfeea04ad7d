"""Rights in worlds: the answer of each request, and a router that lets too much through."""

import struct
from dataclasses import replace

import pytest

from achse.ams import Command
from achse.codes import ReturnCode
from achse.router import rights as router_rights
from achse.swarm.play import play
from achse.swarm.services.rights import ClientRights, may_write, rights_of
from achse.swarm.worlds.world import Act, DrawnClient, DrawnRouter, World

DENIED = int(ReturnCode.DEVICE_ACCESS_DENIED)
HANDLE, RELEASE, VALUE = (struct.pack("<3I", group, 0, 4) for group in (0xF003, 0xF006, 0xF005))
SECOND = 1_000_000_000


def client(*, registers: bool = False) -> DrawnClient:
    return DrawnClient("watch", 0, 0, registers)


def world(*rights: str) -> World:
    router = {"net_id": "10.200.1.1.1.1", "rights": list(rights)}
    acts = [Act(0, 0, "dial"), Act(SECOND // 2, 0, "state", [501])]
    acts.append(Act(SECOND // 2, 0, "lie", ["length", 7]))
    return World(
        *(3, SECOND, 2_000_000),
        clients=[client()],
        acts=acts,
        machine={"router": router, "route": []},
    )


@pytest.mark.parametrize(
    ("command", "data", "needed"),
    [
        (Command.READ, VALUE, "read"),
        (Command.READ_STATE, b"", "read"),
        (Command.ADD_NOTIFICATION, VALUE, "read"),
        (Command.WRITE, VALUE, "write"),
        (Command.WRITE, RELEASE, "read"),
        (Command.READ_WRITE, HANDLE, "read"),
        (Command.WRITE_CONTROL, bytes(8), "state"),
    ],
)
def test_request_without_its_right_must_be_refused(command: int, data: bytes, needed: str) -> None:
    without = ClientRights(frozenset({"read", "write", "state"}) - {needed})
    assert without.wrong_answer(command, data, 0).startswith("is answered with 0x0")
    assert without.wrong_answer(command, data, DENIED) == ""
    with_it = ClientRights(frozenset({needed}))
    assert with_it.wrong_answer(command, data, DENIED).startswith("is refused")
    assert with_it.wrong_answer(command, data, 0x710) == ""


def test_request_that_is_not_in_the_table_may_have_any_answer() -> None:
    assert ClientRights(frozenset()).wrong_answer(Command.READ_WRITE, VALUE, 0) == ""


def test_route_says_what_its_client_may() -> None:
    routed = {"net_id": "10.1.0.1.1.1", "host": "127.0.0.1", "name": "one", "rights": ["write"]}
    machine = {**world("read").machine, "route": [routed]}
    three = replace(world(), machine=machine, clients=[client(), client(), client(registers=True)])
    rights = [rights_of(three, number) for number in range(3)]
    assert [None if each is None else each.names for each in rights] == [{"read"}, {"write"}, None]
    assert may_write(three)
    assert not may_write(replace(three, clients=[client()]))


def test_clients_behind_routers_have_the_rights_of_the_last_one() -> None:
    routed = {"net_id": "10.2.0.0.1.1", "host": "127.0.0.1", "name": "router", "rights": ["write"]}
    machine = {**world("read").machine, "route": [routed]}
    routers = [DrawnRouter(0, 0, True), DrawnRouter(0, 0, True, 0), DrawnRouter(0, 0, True)]
    clients = [replace(client(registers=True), router=number) for number in range(3)]
    chained = replace(world(), machine=machine, clients=clients, routers=routers)
    rights = [rights_of(chained, number) for number in range(3)]
    assert [each and each.names for each in rights] == [{"write"}, {"write"}, {"read"}]
    assert rights[0] is not None
    assert rights[0].wrong_answer(Command.READ, VALUE, 0x1B) == ""
    assert rights[0].wrong_answer(Command.READ, VALUE, 0)


@pytest.mark.parametrize("rights", [(), ("read",), ("read", "write")])
def test_rights_hold(rights: tuple[str, ...]) -> None:
    assert play(world(*rights)).violation is None


def test_router_that_permits_too_much_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        *(router_rights, "_needed_by_write"), lambda group: router_rights.Right.READ
    )
    violation = play(world("read")).violation
    assert violation is not None
    assert violation.invariant == "rights"
