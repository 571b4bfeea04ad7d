"""Requests of the router itself."""

from achse.ams import AmsAddress, Frame, NetId
from achse.gateway.requests import OwnRequests
from achse.router import Router

TARGET = AmsAddress("5.1.2.3.1.1:10000")


class Way:
    """A target that answers `answers` of its requests, the others never."""

    def __init__(self, router: Router, answers: int) -> None:
        self.router = router
        self.answers = answers

    def deliver(self, frame: Frame) -> bool:
        self.answers -= 1
        if self.answers >= 0:
            self.router.deliver(frame.reply(b"\0\0\0\0\5\0\0\0"))
        return True


async def test_state_is_read_and_silence_ends() -> None:
    router = Router(NetId("5.7.7.7.1.1"))
    requests = OwnRequests(router)
    router.add_route(TARGET.net_id, Way(router, 1))
    answer = await requests.read_state(TARGET, 1.0)
    assert answer is not None
    assert answer.data == b"\0\0\0\0\5\0\0\0"
    assert await requests.read_state(TARGET, 0.0) is None
    requests.close()
    assert router.ports == []


async def test_answer_that_comes_late_is_dropped() -> None:
    router = Router(NetId("5.7.7.7.1.1"))
    requests = OwnRequests(router)
    frames: list[Frame] = []

    class Late:
        def deliver(self, frame: Frame) -> bool:
            frames.append(frame)
            return True

    router.add_route(TARGET.net_id, Late())
    assert await requests.read_state(TARGET, 0.0) is None
    assert router.deliver(frames[0].reply(b"\0\0\0\0\5\0\0\0"))
