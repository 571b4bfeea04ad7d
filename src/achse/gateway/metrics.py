"""Figures of `achse router` for Prometheus."""

from collections.abc import Iterator
from typing import Any

from achse.station.running.metrics_port import Figure, Figures, families, labelled_families

_FIGURES = (
    Figure("connections", "connections", "Open TCP connections of programs."),
    Figure("connections_refused", "connections_refused", "Connections not taken.", True),
    Figure("connections_cut_off", "connections_cut_off", "Connections closed by a limit.", True),
    Figure("buffered_bytes", "buffered_bytes", "Bytes that wait on all connections together."),
    Figure("lost_frames", "lost_frames", "Frames without a receiver.", True),
    Figure("requests_denied", "requests_denied", "Requests without their right.", True),
)

_OF_TARGETS = (
    Figure("target_ready", "ready", "1 while the target answers."),
    Figure("target_losses", "losses", "Lost connections to the target.", True),
    Figure("target_refused", "refused", "Requests that could not go.", True),
    Figure("target_overloads", "overloads", "Requests refused for what was under way."),
    Figure("target_returned", "returned", "Answers and samples on the present connection."),
    Figure("target_pending", "pending", "Requests without an answer."),
    Figure("target_waiting", "waiting", "Of these, those that wait in the router."),
    Figure("target_clients", "clients", "Programs that use the target."),
    Figure("target_subscriptions", "subscriptions", "Subscriptions at the target."),
    Figure("target_handles", "handles", "Symbol handles at the target."),
    Figure("target_files", "files", "Open files and searches at the target."),
    Figure("target_latency_50_seconds", "latency_50", "Latency of half of the requests."),
    Figure("target_latency_99_seconds", "latency_99", "Latency of 99 % of the requests."),
)

_OF_CLIENTS = (
    Figure("client_requests", "requests", "Requests of a program.", True),
    Figure("client_errors", "errors", "Of these, those answered with an error.", True),
)


def gateway_families(figures: Figures) -> Iterator[Any]:
    """Yield the families of a router, from its statistics."""
    yield from families(_FIGURES, figures)
    targets = [{**each, "ready": each["state"] == "ready"} for each in figures["targets"]]
    yield from labelled_families(
        *(_OF_TARGETS, targets, ("target", "net_id")),
        lambda target: (target["name"], target["net_id"]),
    )
    yield from labelled_families(
        *(_OF_CLIENTS, figures["clients"], ("client",)), lambda client: (client["address"],)
    )
