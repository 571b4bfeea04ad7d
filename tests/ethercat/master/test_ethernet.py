"""The network of a bus: slaves among each other and with the host."""

from collections.abc import Callable
from typing import Any

from achse.codes import AlState
from tests.ethercat.master.messaging import Messenger


def frame(target: int, source: int, size: int = 60) -> bytes:
    head = bytes((2, 0, 0, 0, 0, target, 2, 0, 0, 0, 0, source, 8, 0))
    return head.ljust(size, b"x")


def test_slaves_and_host_reach_each_other(bus: Callable[..., Any]) -> None:
    ours = bus(3, kind=Messenger).up(AlState.OP)
    network = ours.master.ethernet
    assert list(network.ports) == [1001, 1002, 1003]
    came: list[bytes] = []
    host = network.switch.attach("host", came.append)
    for number, device in enumerate(ours.line, 1):
        device.send_frame(frame(100, number, 1514))  # nobody is known yet
    ours.until(lambda: len(came) == 3)
    ours.until(lambda: all(len(device.frames) == 2 for device in ours.line))
    assert sorted(came) == [frame(100, number, 1514) for number in (1, 2, 3)]
    network.switch.send(host, frame(2, 100))
    ours.line[0].send_frame(frame(3, 1))
    ours.until(lambda: frame(2, 100) in ours.line[1].frames and frame(3, 1) in ours.line[2].frames)
    ours.run(50)
    assert [len(device.frames) for device in ours.line] == [2, 3, 3]


def test_a_slave_without_a_mailbox_now_gets_nothing(bus: Callable[..., Any]) -> None:
    ours = bus(kind=Messenger)
    network = ours.master.ethernet
    host = network.switch.attach("host")
    network.switch.send(host, frame(1, 9))
    ours.up(AlState.PREOP)
    for number in range(40):
        network.switch.send(host, frame(1, 9) + bytes((number,)))
    assert network.ports[1001].dropped == 9
    ours.until(lambda: len(ours.line[0].frames) == 32)


def test_slaves_that_do_not_speak_it_have_no_port(bus: Callable[..., Any]) -> None:
    assert bus().master.ethernet.ports == {}
