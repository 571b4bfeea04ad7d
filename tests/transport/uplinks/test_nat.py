"""NetIds are changed on the way, and nothing else, however the stream is cut."""

from types import SimpleNamespace
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from achse.ams import AmsAddress, Frame, NetId
from achse.transport.connections.fair_queue import FairQueue
from achse.transport.connections.send_budget import SendBudget
from achse.transport.uplinks.nat import NatPeer

OURS, THEIRS, OTHER = (NetId(f"5.0.0.{n}.1.1") for n in (1, 2, 3))
NET_IDS = st.sampled_from((OURS, THEIRS, OTHER))


@given(
    st.lists(st.tuples(NET_IDS, NET_IDS, st.binary(max_size=40)), max_size=8), st.integers(1, 90)
)
def test_only_senders_come_and_targets_go_under_another_net_id(
    frames: list[tuple[NetId, NetId, bytes]], portion: int
) -> None:
    router: Any = SimpleNamespace(
        seen=[],
        net_id=OTHER,
        journal=None,
        is_local=lambda _: True,
        learn=lambda *_: None,
        local_endpoint=lambda _: None,
        lost_frames=0,
    )
    router.deliver = lambda frame: router.seen.append(frame) or True
    line = SimpleNamespace(written=b"", get_write_buffer_size=lambda: 0)
    line.write = lambda data: setattr(line, "written", line.written + data)
    scheduler = SimpleNamespace(time=lambda: 0.0, call_soon=lambda call: call())
    owner: Any = SimpleNamespace(
        router=router,
        loop=scheduler,
        max_length=1000,
        max_backlog=10_000,
        send_budget=SendBudget(),
        fair_queue=FairQueue(),
        routes_required=False,
        memory=None,
        serves_ports=lambda host: True,
        opened=lambda peer: None,
    )
    peer = NatPeer(owner, OURS, THEIRS)
    peer.begin(line)
    stream = b""
    for target, source, data in frames:
        frame = Frame(AmsAddress.of(target, 1), AmsAddress.of(source, 2), 2, 4, 0, 7, data)
        stream += frame.encode_tcp()
        peer.deliver(frame)
    for start in range(0, len(stream), portion):
        peer.receive(stream[start : start + portion])
    assert [(f.target[:6], f.source[:6], f.data) for f in router.seen] == [
        (target, OURS if source == THEIRS else source, data) for target, source, data in frames
    ]
    sent = [
        Frame(AmsAddress.of(THEIRS if target == OURS else target, 1), AmsAddress.of(source, 2), 2)
        for target, source, _ in frames
    ]
    for frame, (_, _, data) in zip(sent, frames, strict=True):
        frame.invoke_id, frame.data = 7, data
    assert line.written == b"".join(frame.encode_tcp() for frame in sent)
