"""Requests on their way to partners that may vanish."""

from achse.ams import AmsAddress, Flags, Frame
from achse.transport.mqtt import partner_requests
from achse.transport.mqtt.partner_requests import PartnerRequests

PANEL = AmsAddress("5.0.0.1.1.1:30000")
PRESS, SAW = AmsAddress("5.0.0.2.1.1:851"), AmsAddress("5.0.0.3.1.1:851")


def ask(target: AmsAddress, invoke_id: int, flags: int = 4) -> Frame:
    return Frame(target, PANEL, 2, flags, 0, invoke_id, bytes(12))


def test_requests_to_a_router_fail_with_it() -> None:
    requests = PartnerRequests()
    for frame in (ask(PRESS, 1), ask(PRESS, 2), ask(SAW, 1), ask(SAW, 9, 4 | Flags.NO_RESPONSE)):
        requests.add(frame)
    requests.add(ask(PRESS, 7).reply())
    assert len(requests) == 3
    requests.answered(ask(PRESS, 1).reply().encode_tcp()[6:])
    requests.answered(ask(PANEL, 2).encode_tcp()[6:])
    (failed,) = requests.fail(PRESS.net_id)
    assert (failed.target, failed.source, failed.error, failed.invoke_id) == (PANEL, PRESS, 7, 2)
    assert failed.is_response
    assert not requests.fail(PRESS.net_id)
    assert len(requests) == 1


def test_the_oldest_is_forgotten() -> None:
    requests = PartnerRequests()
    for number in range(partner_requests._MOST + 5):
        requests.add(ask(PRESS, number))
    assert len(requests) == partner_requests._MOST
    assert requests.fail(PRESS.net_id)[0].invoke_id == 5
