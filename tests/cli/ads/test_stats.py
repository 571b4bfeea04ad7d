"""`achse ads stats`: how a station of ours is doing."""

from collections.abc import Callable
from typing import Any

from achse.testing import FakeDevice


def test_figures(lines: Callable[..., list[str]]) -> None:
    shown = [line.split() for line in lines("ads", "stats")]
    assert ["connections", "1"] in shown
    assert any(line[:1] == ["851"] and "RUN" in line for line in shown)
    assert next(line[:6] for line in shown if line[:1] == ["ports"]) == [
        "ports",
        "device",
        "state",
        "clients",
        "subscriptions",
        "handles",
    ]


def test_the_figures_have_those_of_the_router(lines: Callable[..., list[str]]) -> None:
    words = [line.split() for line in lines("ads", "stats") if line.startswith("router ")]
    assert ["router", "routes", "0"] in words
    assert ["router", "memory", "700", "kB"] in words


def test_json(document: Callable[..., Any]) -> None:
    figures = document("ads", "stats")
    assert figures["connections"] == 1
    assert figures["router"]["memory"] == 700
    assert {1, 851, 10_000} <= set(figures["router"]["ports"])
    ports = [device["ports"] for device in figures["devices"]]
    assert {(10_000,), (500, 501), (851,), (26_000,)} <= set(map(tuple, ports))


def test_what_is_no_station_of_ours_is_reported(cli: Callable[..., Any]) -> None:
    with FakeDevice().serving() as live:
        place = ("--host", live.host, "--tcp-port", str(live.tcp_port))
        refusal = cli("ads", "stats", *place, exit_code=1)
    assert f"{live.host}:{live.tcp_port} is not an achse station" in refusal.stderr
