"""Requests of the router: nothing of a client that is gone remains at its target."""

import pytest

from achse.router.forwarding import router_requests
from tests.router.chains import Chain


def test_releases_go_on_when_the_target_answers_none_of_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    chain = Chain(1)
    client = chain.client()
    handles = client.fetch_many(200)
    assert len(handles) == 200
    monkeypatch.setattr(chain.target.device, "_reply", lambda response: None)
    client.wire.close()
    chain.loop.run()
    assert chain.target.held_by_clients[1] == 200 - router_requests._RELEASES_AT_ONCE
    chain.loop.run(4.0)
    assert chain.target.held_by_clients == (0, 0)
