"""Access guard: hosts, origins and tokens."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.web.access_guard import AccessGuard

HOST = "127.0.0.1:8080"


def status(guard: AccessGuard, token: str | None = None, cookie: str = "", **headers: str) -> int:
    """HTTP status of a refusal, 0 for who gets in."""
    named = {name.replace("_", "-"): value for name, value in ({"host": HOST} | headers).items()}
    query = {} if token is None else {"token": token}
    refusal = guard.refusal(named, query, {guard.cookie: cookie})
    return 0 if refusal is None else refusal[0]


@pytest.mark.parametrize(
    ("headers", "expected"),
    [
        ({}, 0),
        ({"origin": f"http://{HOST}"}, 0),
        ({"host": "localhost:8080", "origin": "http://localhost:8080"}, 0),
        ({"host": "[::1]:8080", "origin": "http://[::1]:8080"}, 0),
        ({"origin": "http://evil.example"}, 403),
        ({"origin": "http://127.0.0.1:9"}, 403),
        ({"origin": "null"}, 403),
        ({"origin": f"file://{HOST}"}, 403),
        ({"origin": "http://[::1"}, 403),
        ({"host": "evil.example", "origin": "http://evil.example"}, 421),
        ({"host": ""}, 421),
        ({"host": "[::"}, 421),
        ({"sec_fetch_site": "cross-site", "sec_fetch_mode": "no-cors"}, 403),
        ({"sec_fetch_site": "cross-site", "sec_fetch_mode": "navigate"}, 0),
        ({"sec_fetch_site": "cross-site"}, 403),
        ({"sec_fetch_site": "same-site", "sec_fetch_mode": "no-cors"}, 0),
        ({"sec_fetch_site": "none", "sec_fetch_mode": "no-cors"}, 0),
        ({"sec_fetch_mode": "no-cors"}, 0),
        (
            {
                "origin": f"http://{HOST}",
                "sec_fetch_site": "cross-site",
                "sec_fetch_mode": "no-cors",
            },
            0,
        ),
        ({"origin": f"https://{HOST}"}, 0),
        ({"host": "LocalHost:8080", "origin": "http://LOCALHOST:8080"}, 0),
        ({"host": "localhost.example"}, 421),
    ],
)
def test_without_a_token_only_pages_of_this_computer(
    headers: dict[str, str], expected: int
) -> None:
    assert status(AccessGuard("", 8080), **headers) == expected


def test_with_a_token_every_name_is_served_and_without_it_none() -> None:
    guard = AccessGuard("geheim", 8080)
    there = {"host": "plc.example:8080", "origin": "http://plc.example:8080"}
    assert status(guard, **there) == 401
    assert (guard.locked, AccessGuard("", 8080).locked) == (True, False)
    assert status(guard, "geheim", host="") == 421
    assert status(guard, "geheim", host=":8080") == 421
    assert status(guard, "falsch", **there) == 401
    assert status(guard, "geheim", **there) == 0
    assert status(guard, None, "geheim", **there) == 0
    assert status(guard, "falsch", "geheim", **there) == 401
    assert status(guard, "geheim", host="plc.example", origin="http://evil.example") == 403


@given(st.text(), st.text(), st.text(min_size=1), st.text(), st.text())
def test_whatever_comes_is_let_in_or_refused(
    host: str, origin: str, token: str, given_token: str, cookie: str
) -> None:
    guard = AccessGuard(token, 1)
    if status(guard, given_token, cookie, host=host, origin=origin) == 0:
        assert given_token == token
        assert origin.lower().endswith(host.lower())


def test_tokens_are_new_each_time_and_cookies_know_the_port() -> None:
    tokens = {AccessGuard.new_token() for _ in range(20)}
    assert len(tokens) == 20
    assert {len(token) for token in tokens} == {24}  # 144 bits
    assert AccessGuard("x", 1).cookie != AccessGuard("x", 2).cookie
