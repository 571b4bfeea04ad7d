"""A client of a forwarding router: idle or not, and hints for its subscriptions."""

from achse.ams import AmsAddress, Command, Frame
from achse.ams.notification import NotificationStream
from achse.router.forwarding.forwarded_client import ForwardedClient
from achse.router.forwarding.ledger import Resource, ResourceKind
from achse.router.forwarding.pending import PendingExchange, PendingRequest

PLC = bytes(AmsAddress("5.0.0.9.1.1:851"))
SOURCE = bytes(AmsAddress("192.168.0.9.1.1:30000"))


class Connection:
    def deliver(self, frame: Frame) -> bool:
        return True


def test_client_is_idle_without_requests_releases_and_resources() -> None:
    client = ForwardedClient(Connection(), SOURCE, SOURCE, False)
    assert client.idle
    client.releasing = 1
    assert not client.idle
    client.releasing = 0
    exchange = client.exchanges[PLC] = PendingExchange(client, PLC)
    exchange.requests[1] = PendingRequest(client, Command.READ, 4, None, 0, 0)
    assert client.pending
    assert not client.idle
    exchange.requests.clear()
    assert client.idle
    client.resources[Resource(ResourceKind.SYMBOL_HANDLE, PLC, 7)] = 1
    assert not client.idle


def test_hints_name_each_subscription_and_go_to_the_client() -> None:
    connection = Connection()
    client = ForwardedClient(connection, SOURCE, PLC, False)
    client.resources[Resource(ResourceKind.SYMBOL_HANDLE, PLC, 7)] = 1
    client.resources[Resource(ResourceKind.SUBSCRIPTION, PLC, 8)] = 1
    [hint] = client.end_hints()
    assert (hint.command, hint.via) == (Command.NOTIFICATION, connection)
    assert (hint.target, hint.source) == (SOURCE, PLC)
    [(filetime, samples)] = NotificationStream.decode(hint.data).stamps
    assert (filetime, [tuple(each) for each in samples]) == (0, [(8, b"")])
