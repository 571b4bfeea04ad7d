"""The link to a target: it is watched, dialled again, and its state is told once."""

import logging

import pytest

from achse.ams import AmsAddress, Frame, NetId
from achse.gateway.target import TargetState
from tests.gateway.stations import NET_ID, gateway, running_target, target_at, until


async def test_target_that_restarts_is_ready_again(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
    async with running_target() as target:
        table = target_at(target, keep_alive="1ms")
        router = gateway(table)
        running = router.running("127.0.0.1", 0, udp_port=0)
        await running.__aenter__()
        [link] = router.targets
        assert link.state is TargetState.READY
        assert link.ads_state == 5
    await until(lambda: link.state is TargetState.UNREACHABLE)
    async with running_target(tcp_port=link.config.endpoint[1]):
        await until(lambda: link.state is TargetState.READY)
    assert caplog.text.count("target press is ready") == 2
    assert caplog.text.count("target press is unreachable") == 1
    await running.__aexit__(None, None, None)


async def test_target_that_falls_silent_is_dialled_again() -> None:
    """A cable that is pulled ends no connection: only the query of the state tells."""
    async with running_target() as target:
        table = target_at(target, keep_alive="1ms", timeout="50ms")
        async with gateway(table).running("127.0.0.1", 0, udp_port=0) as router:
            [link] = router.targets
            uplink = link.uplink
            assert uplink is not None
            await until(lambda: link.state is TargetState.READY)
            swallowed: list[Frame] = []

            def swallow(frame: Frame, deliver: object) -> bool:
                swallowed.append(frame)
                return True

            target.listener.router.set_frame_filter(swallow)
            await until(lambda: uplink.losses)
            assert swallowed
            target.listener.router.set_frame_filter(None)
            await until(lambda: link.state is TargetState.READY)
            assert uplink.connections >= 2


async def test_silent_system_service_does_not_end_a_link_that_is_used() -> None:
    """A target that is busy for one client, or has no port 10000, keeps its connection."""
    async with running_target() as target:
        table = target_at(target, keep_alive="1ms", timeout="20ms")
        async with gateway(table).running("127.0.0.1", 0, udp_port=0) as router:
            [link] = router.targets
            uplink = link.uplink
            assert uplink is not None
            await until(lambda: link.state is TargetState.READY)
            silent = 0

            def others_only(frame: Frame, deliver: object) -> bool:
                nonlocal silent
                if AmsAddress(frame.target).port == 10_000 and frame.command == 4:
                    silent += 1
                    forwarding = None if uplink.peer is None else uplink.peer.forwarding
                    assert forwarding is not None
                    forwarding.returned += 1  # an answer to another client
                return True

            target.listener.router.set_frame_filter(others_only)
            await until(lambda: silent > 3)
            assert (uplink.losses, str(NetId(NET_ID))) == (0, NET_ID)
