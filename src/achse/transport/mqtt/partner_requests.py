"""Pending requests to partners over MQTT, where no connection ends when a partner vanishes."""

from achse.ams import Command, Flags, Frame
from achse.ams.frame import AMS_HEADER
from achse.codes import ReturnCode

_MOST = 16_384
"""Highest number of pending requests; the oldest is dropped for a further one."""


class PartnerRequests:
    """Pending requests to partners, and their answers if a partner vanishes."""

    def __init__(self) -> None:
        self._requests: dict[tuple[bytes, bytes, int], Frame] = {}

    def __len__(self) -> int:
        return len(self._requests)

    def add(self, frame: Frame) -> None:
        """Add `frame` if it is a request that expects an answer."""
        if frame.is_response or frame.command == Command.NOTIFICATION:
            return
        if frame.flags & Flags.NO_RESPONSE:
            return
        if len(self._requests) >= _MOST:
            del self._requests[next(iter(self._requests))]
        head = (frame.target, frame.source, frame.command, frame.flags, 0, frame.invoke_id)
        self._requests[frame.source, frame.target, frame.invoke_id] = Frame(*head)

    def answered(self, message: bytes) -> None:
        """Remove the request that `message` answers, if it is a response."""
        target, source, _, flags, _, _, invoke_id = AMS_HEADER.unpack_from(message)
        if flags & Flags.RESPONSE:
            self._requests.pop((target, source, invoke_id), None)

    def fail(self, net_id: bytes) -> list[Frame]:
        """Remove the requests to a router that is offline, and return their answers with 0x7."""
        keys = [key for key in self._requests if key[1][:6] == net_id]
        requests = [self._requests.pop(key) for key in keys]
        return [each.reply(error=ReturnCode.TARGET_MACHINE_NOT_FOUND.number) for each in requests]
