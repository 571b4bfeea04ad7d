"""Handles that ended connections left at a target are released before anything else goes there."""

from io import BytesIO
from typing import Any

import pytest

from achse.ams import Command, DeviceError
from achse.ams.commands import ReadWriteRequest
from achse.codes import ReturnCode
from achse.router.forwarding.journal import HandleJournal
from achse.server.handles import HandleTable
from tests.router.chains import PLC, Chain
from tests.router.stations import Client, line_of


@pytest.fixture
def foreign_target(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """A target that releases handles by number alone, of each client; the numbers that it got."""
    released: list[int] = []

    def release(table: HandleTable[Any], number: int, client: bytes) -> None:
        released.append(number)
        if number not in table.valid:
            raise DeviceError(ReturnCode.SYMBOL_VERSION_INVALID, "unknown")
        table.end(number)

    def refuse(table: HandleTable[Any], client: bytes) -> None:
        raise DeviceError(ReturnCode.INVALID_SIZE, "a handle is 4 bytes")

    monkeypatch.setattr(HandleTable, "release", release)
    monkeypatch.setattr(HandleTable, "release_abandoned", refuse)
    return released


def chain_of(clients: int, handles: int) -> tuple[Chain, list[Client]]:
    chain = Chain(1, source_nat=True, journals=True)
    result = [chain.client() for _ in range(clients)]
    for client in result:
        for _ in range(handles):
            client.fetch()
    return chain, result


def test_handle_whose_answer_was_under_way_is_released() -> None:
    chain, [client] = chain_of(1, 0)
    client.send(Command.READ_WRITE, ReadWriteRequest(0xF003, 0, 4, client.name()).encode())
    while not chain.target.held_by_clients[1]:
        chain.loop.run(1.0, 1)
    chain.kill(0)
    chain.loop.run(0.0)
    assert chain.target.held_by_clients == (0, 0)


def test_lost_connection_leaves_no_handle_at_a_target_that_stays() -> None:
    chain, clients = chain_of(3, 100)
    for peer in list(chain.target.peers):
        line_of(peer).abort()
    chain.loop.run(20.0)
    assert [client.gone for client in clients] == [True] * 3
    assert chain.target.held_by_clients == (0, 0)
    journal = chain.hosts[0].router.journal
    assert journal is not None
    assert (len(journal), journal.handles_at(chain.target.router.net_id)) == (0, [])


def test_foreign_target_gets_each_number(foreign_target: list[int]) -> None:
    chain, _ = chain_of(3, 100)
    chain.kill(0)
    chain.loop.run(1.0)
    assert len(foreign_target) == len(set(foreign_target)) == 300
    assert chain.target.held_by_clients == (0, 0)


def test_foreign_target_that_restarted_is_left_alone(foreign_target: list[int]) -> None:
    chain, _ = chain_of(3, 100)
    chain.reachable = False
    chain.kill(0)
    chain.restart_target()
    chain.target.time_ns += 3600 * 10**9  # its handles have other numbers
    direct = Client(chain.target, 0, chain.client().address, PLC)
    own = [direct.fetch() for _ in range(50)]
    chain.reachable = True
    chain.hosts[0].uplinks[0].remembered()
    chain.loop.run(20.0)
    assert len(foreign_target) == 2
    assert all(direct.read(handle) is not None for handle in own)


def test_requests_wait_until_handles_of_before_are_released(foreign_target: list[int]) -> None:
    chain, _ = chain_of(1, 200)
    chain.kill(0)
    [uplink] = chain.hosts[0].uplinks
    client = chain.client()
    chain.loop.run(0.0, 12)
    assert not uplink.connected
    handle = client.fetch()
    assert handle not in foreign_target
    assert client.read(handle) is not None
    assert chain.target.held_by_clients == (0, 1)


def test_target_that_answers_nothing_holds_clients_up_for_a_while(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    chain, _ = chain_of(1, 3)
    chain.kill(0)
    with monkeypatch.context() as patch:
        patch.setattr(chain.target.device, "_reply", lambda response: None)
        chain.loop.run(8.0)
    assert chain.hosts[0].uplinks[0].connected
    assert "no answer, 3 may stay at the target" in caplog.text
    client = chain.client()
    assert client.read(client.fetch()) is not None


def test_connection_that_ends_meanwhile_is_followed_by_another(foreign_target: list[int]) -> None:
    chain, _ = chain_of(1, 200)
    chain.kill(0)
    while len(foreign_target) < 100:
        chain.loop.run(1.0, 1)
    for peer in list(chain.target.peers):
        line_of(peer).abort()
    chain.loop.run(20.0)
    assert chain.target.held_by_clients == (0, 0)
    assert not len(HandleJournal(BytesIO(chain.files[0].getvalue())))
