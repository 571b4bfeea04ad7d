"""Figures of a gateway: clients, targets, requests, latencies, losses; read at port 1 as JSON."""

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Protocol

from achse.gateway.target import Target
from achse.router import Router
from achse.router.forwarding.ledger import ResourceKind
from achse.server import RawGroup
from achse.transport.tcp.listener import TcpListener

STATISTICS = 2
"""Index group of the figures at port 1."""


class CountedGateway(Protocol):
    """Interface of the gateway to its figures."""

    router: Router
    targets: Sequence[Target]

    @property
    def listeners(self) -> Iterable[TcpListener]: ...


def statistics(gateway: CountedGateway) -> dict[str, Any]:
    """Return the present figures; latencies in seconds."""
    router, listeners = gateway.router, list(gateway.listeners)
    return {
        "connections": sum(len(each.connections) for each in listeners),
        "connections_refused": sum(each.refused for each in listeners),
        "connections_cut_off": sum(each.cut_off for each in listeners),
        "buffered_bytes": sum(budget.total for budget in {each.send_budget for each in listeners}),
        "lost_frames": router.lost_frames,
        "requests_denied": router.denied,
        "clients": [router.client_row(each) for each in router.client_figures.busiest()],
        "targets": [_of_target(each) for each in gateway.targets],
    }


def _of_target(target: Target) -> Mapping[str, Any]:
    uplink = target.uplink
    forwarding = None if uplink is None or uplink.peer is None else uplink.peer.forwarding
    resources = [] if forwarding is None else [each.kind for _, each in forwarding.resources]
    latencies = None if forwarding is None else forwarding.latencies
    return {
        "name": target.config.title,
        "net_id": "" if target.net_id is None else str(target.net_id),
        "host": target.config.host,
        "state": target.state.value,
        "advice": target.advice,
        "ads_state": target.ads_state,
        "connected": uplink is not None and uplink.connected,
        "losses": 0 if uplink is None else uplink.losses,
        "refused": 0 if uplink is None else uplink.refused,
        "overloads": 0 if forwarding is None else forwarding.refused,
        "returned": 0 if forwarding is None else forwarding.returned,
        "pending": 0 if forwarding is None else forwarding.pending,
        "waiting": 0 if forwarding is None else len(forwarding.windows),
        "clients": 0 if forwarding is None else sum(1 for _ in forwarding.clients),
        "subscriptions": resources.count(ResourceKind.SUBSCRIPTION),
        "handles": resources.count(ResourceKind.SYMBOL_HANDLE),
        "files": resources.count(ResourceKind.FILE),
        "latency_50": 0.0 if latencies is None else latencies.within_ns(0.5) / 1e9,
        "latency_99": 0.0 if latencies is None else latencies.within_ns(0.99) / 1e9,
    }


def statistics_group(gateway: CountedGateway) -> RawGroup:
    """Return the index group that has the figures as JSON."""
    return RawGroup(
        STATISTICS,
        "statistics",
        read=lambda offset, length, client: json.dumps(statistics(gateway)).encode(),
        response="JSON",
        description="Clients, targets, requests, latencies, losses of `achse router`.",
        source="achse",
    )
