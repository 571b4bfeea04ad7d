"""The NetId of a slave that speaks AoE: what is sent there travels in its mailbox.

The slave answers at whatever AMS ports it has (0x1000 + channel is usual); its own requests reach
devices of this station.

Source: ETG.1020 (AoE); the NetId of a slave is ours to choose.
"""

from achse.ams import Command, Frame, NetId
from achse.codes import ReturnCode
from achse.devices.io.later import MAX_WAITING
from achse.devices.io.served import ServedBus, bus_error
from achse.ethercat.master import BusError, BusJob, BusSlave
from achse.ethercat.master.aoe_client import AoeClient
from achse.router import Router

_U32 = 0xFFFF_FFFF


class SlaveNet:
    """A route to one slave, until `close`. `dropped` counts what it sent without a right to."""

    def __init__(self, router: Router, bus: ServedBus, slave: BusSlave, net_id: NetId) -> None:
        assert slave.aoe is not None
        self.net_id = net_id
        self.dropped = 0
        self._router = router
        self._bus = bus
        self._slave = slave
        self._aoe: AoeClient = slave.aoe
        self._aoe.take = self._came
        self._invoke_id = 0
        router.add_route(net_id, self)

    def close(self) -> None:
        """Take the NetId off the router."""
        self._aoe.take = None
        self._router.remove_route(self.net_id)

    def deliver(self, frame: Frame) -> bool:
        """Send a frame to the slave; the answer to a request goes back the way it came."""
        answered = not frame.is_response and frame.command != Command.NOTIFICATION
        refusal = self._refusal(frame)
        if refusal is not None:
            return answered and self._router.deliver(frame.reply(error=refusal.number))
        if not answered:
            self._bus.master.run(self._aoe.send(frame.encode()))
            return True
        self._invoke_id = self._invoke_id % _U32 + 1
        packet = Frame(
            frame.target, frame.source, frame.command, frame.flags, 0, self._invoke_id, frame.data
        )
        self._bus.master.run(
            self._aoe.request(packet.encode()), lambda job: self._answer(frame, job)
        )
        return True

    def _refusal(self, frame: Frame) -> ReturnCode | None:
        if self._bus.master.traffic.waiting >= MAX_WAITING:
            return ReturnCode.BUSY
        if not self._slave.speaks:
            return ReturnCode.INVALID_STATE
        if len(frame.data) + 32 > self._aoe.room:
            return ReturnCode.INVALID_SIZE
        return None

    def _answer(self, frame: Frame, job: BusJob[bytes]) -> None:
        try:
            answer = Frame.decode(job.result())
        except BusError as trouble:
            self._router.deliver(frame.reply(error=int(bus_error(trouble).code)))
            return
        self._router.deliver(frame.reply(answer.data, answer.error))

    def _came(self, packet: bytes) -> None:
        """Deliver a request that the slave sends in its own name to this station; drop other
        frames."""
        frame = Frame.decode(packet)
        if (
            frame.source[:6] != self.net_id
            or not self._router.is_local(frame.target[:6])
            or frame.is_response
        ):
            self.dropped += 1
            return
        frame.origin = self
        self._router.deliver(frame)
