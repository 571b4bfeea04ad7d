"""Rights in a world: a request that they forbid is refused, and changes nothing.

The table says once more, without the router's, which right each request of a client needs.
"""

from collections.abc import Mapping
from typing import Any

from achse.ams import Command
from achse.codes import ReturnCode
from achse.codes.groups import ReservedGroup
from achse.swarm.services.drawing import net_id_of
from achse.swarm.worlds.world import World

_BY_COMMAND: Mapping[int, str] = {
    Command.READ_DEVICE_INFO: "read",
    Command.READ: "read",
    Command.READ_STATE: "read",
    Command.ADD_NOTIFICATION: "read",
    Command.DELETE_NOTIFICATION: "read",
    Command.WRITE: "write",
    Command.WRITE_CONTROL: "state",
}

_READING = (ReservedGroup.SYMBOL_HANDLE_BY_NAME, ReservedGroup.SUM_READ)
_GIVING_BACK = ReservedGroup.RELEASE_SYMBOL_HANDLE


class ClientRights:
    """Rights of a client, by their names."""

    def __init__(self, names: frozenset[str]) -> None:
        self.names = names

    def forbids(self, command: int, data: bytes) -> bool | None:
        """Return True if a request is forbidden; None for one that the table does not know."""
        group = int.from_bytes(data[:4], "little") if len(data) >= 4 else -1
        needed = _BY_COMMAND.get(command)
        reads = command == Command.READ_WRITE and group in _READING
        if reads or (command == Command.WRITE and group == _GIVING_BACK):
            needed = "read"
        return None if needed is None else needed not in self.names

    def wrong_answer(self, command: int, data: bytes, code: int) -> str:
        """Return what is wrong with the code of an answer, if it is."""
        denied = code == int(ReturnCode.DEVICE_ACCESS_DENIED)
        forbidden = self.forbids(command, data)
        if forbidden and not denied:
            return f"is answered with {code:#x}, its client has {sorted(self.names) or 'no rights'}"
        if forbidden is False and denied:
            return f"is refused, its client has {sorted(self.names)}"
        return ""


def rights_of(world: World, client: int) -> ClientRights | None:
    """Return the rights of a client; None if it may everything.

    A client with a port of the router is a program of the station's own computer.
    """
    machine: Mapping[str, Any] = world.machine
    if "route" not in machine or world.clients[client].registers:
        return None
    for route in machine["route"]:
        if route["net_id"] == net_id_of(client):
            return ClientRights(frozenset(route["rights"]))
    return ClientRights(frozenset(machine["router"]["rights"]))


def may_write(world: World) -> bool:
    """Return True if any client of a world may command an axis."""
    return any(
        rights is None or "write" in rights.names
        for rights in (rights_of(world, number) for number in range(len(world.clients)))
    )
