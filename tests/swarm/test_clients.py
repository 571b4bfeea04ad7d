"""Clients: what they send, and what they keep of the answers."""

import pytest

from achse.client.nc.services import FUNCTIONS
from achse.swarm.clients import Client, encode_service
from achse.swarm.play import play
from achse.swarm.worlds.drawing import draw_world
from achse.swarm.worlds.world import Act, DrawnClient, World


def test_request_of_a_service_has_the_layout_with_so_many_values() -> None:
    assert encode_service(FUNCTIONS, "stop", []) == b""
    short = encode_service(FUNCTIONS, "couple", [1, 2, 0, 0, 0.5, 0, 0, 0])
    assert len(short) == 48
    assert short[:8] == bytes((1, 0, 0, 0, 2, 0, 0, 0))
    with pytest.raises(ValueError, match="3 values"):
        encode_service(FUNCTIONS, "couple", [1, 2, 3])


@pytest.mark.parametrize("registers", [True, False])
def test_client_subscribes_reads_and_lies(registers: bool) -> None:
    source = draw_world(4)
    acts = [Act(0, 0, "dial"), Act(10_000_000, 0, "handle", [0])]
    acts += [
        Act(100_000_000, 0, "subscribe", [0, True, 20_000_000, 0]),
        Act(200_000_000, 0, "use", [0, None]),
        Act(210_000_000, 0, "subscribe_axis", [1, False, 20_000_000, 0]),
        Act(220_000_000, 0, "state", [501]),
        Act(230_000_000, 0, "sum", [3]),
        Act(240_000_000, 0, "flood", [20, 2]),
        Act(300_000_000, 0, "unsubscribe", [1]),
        Act(310_000_000, 0, "release", [0]),
    ]
    lies = ("group", "length", "port", "handle", "delete", "short", "command", "answer", "samples")
    acts += [Act(400_000_000 + n, 0, "lie", [lie, 12_345]) for n, lie in enumerate(lies)]
    acts.append(Act(500_000_000, 0, "lie", ["bytes", 3]))
    part = DrawnClient("watch", 1_000_000, 0, registers)
    world = World(4, 600_000_000, 2_000_000, source.axes, (), source.programs, [part], {}, acts)
    outcome = play(world)
    assert outcome.violation is None
    assert outcome.requests == 35
    assert outcome.samples > 5


def test_client_without_a_connection_does_nothing() -> None:
    class Nowhere:
        net_id = draw_world(1)

        def dial(self, client: Client) -> None:
            return None

        def now_ns(self) -> int:
            return 0

    client = Client(0, DrawnClient("lie", 0, 0, True), Nowhere(), ["MAIN.n"])  # type: ignore[arg-type]
    client.dial()
    client.use(0, 1)
    client.state(851)
    client.leave()
    assert client.requests == 0
    assert client.page is None
