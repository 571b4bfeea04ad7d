"""Requests that the router itself sends to its targets."""

import asyncio

from achse.ams import AmsAddress, Command, Flags, Frame
from achse.router import Router


class OwnRequests:
    """A port of the router from which it queries the states of its targets."""

    def __init__(self, router: Router) -> None:
        self._router = router
        self._address = router.register(0, self)
        self._pending: dict[int, asyncio.Future[Frame]] = {}
        self._last_id = 0

    def deliver(self, frame: Frame) -> bool:
        """Accept the answer to a request."""
        future = self._pending.pop(frame.invoke_id, None)
        if future is not None and not future.done():
            future.set_result(frame)
        return True

    async def read_state(self, target: AmsAddress, seconds: float) -> Frame | None:
        """Return the answer to a ReadState; None if none comes within `seconds`."""
        self._last_id = self._last_id % 0x7FFF_FFFF + 1
        invoke_id = self._last_id
        future: asyncio.Future[Frame] = asyncio.get_running_loop().create_future()
        self._pending[invoke_id] = future
        head = (target, self._address, Command.READ_STATE, Flags.ADS_COMMAND)
        self._router.deliver(Frame(*head, 0, invoke_id, b""))
        try:
            async with asyncio.timeout(seconds):
                return await future
        except TimeoutError:
            return None
        finally:
            self._pending.pop(invoke_id, None)

    def close(self) -> None:
        """Free the port."""
        self._router.unregister(self._address.port)
