"""Rights in a world: a request that they forbid is refused, and changes nothing.

The table says once more, without the router's, which right each request of a client needs.
"""

from collections.abc import Mapping
from typing import Any

from achse.ams import Command
from achse.codes import ReturnCode
from achse.codes.groups import ReservedGroup
from achse.swarm.services.drawing import net_id_of, net_id_of_router
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
    """Rights of a client, by their names.

    A router between refuses some requests by itself: then a forbidden one has any code but 0.
    """

    def __init__(self, names: frozenset[str], *, is_routed: bool = False) -> None:
        self.names = names
        self._is_routed = is_routed

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
        if forbidden and not denied and not (self._is_routed and code):
            return f"is answered with {code:#x}, its client has {sorted(self.names) or 'no rights'}"
        if forbidden is False and denied:
            return f"is refused, its client has {sorted(self.names)}"
        return ""


def rights_of(world: World, client: int) -> ClientRights | None:
    """Return the rights of a client; None if it may everything.

    A client with a port of the station's router is a program of its computer. Those behind a router
    have the rights of that router.
    """
    machine: Mapping[str, Any] = world.machine
    part = world.clients[client]
    if "route" not in machine or (part.router < 0 and part.registers):
        return None
    net_id, router = net_id_of(client), part.router
    while router >= 0:  # the station sees the router that is next to it
        net_id, router = net_id_of_router(router), world.routers[router].behind
    names = machine["router"]["rights"]
    for route in machine["route"]:
        if route["net_id"] == net_id:
            names = route["rights"]
    return ClientRights(frozenset(names), is_routed=part.router >= 0)


def may_write(world: World) -> bool:
    """Return True if any client of a world may command an axis."""
    return any(
        rights is None or "write" in rights.names
        for rights in (rights_of(world, number) for number in range(len(world.clients)))
    )
