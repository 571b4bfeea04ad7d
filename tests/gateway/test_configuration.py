"""router.toml and the targets of a command line."""

from pathlib import Path

import pytest

from achse.gateway.configuration import configuration_of
from achse.router.routes import TlsKind
from achse.station.configuration.types import ConfigError


def test_file_has_tables_of_a_router_and_targets(tmp_path: Path) -> None:
    path = tmp_path / "router.toml"
    fingerprint = "ab" * 32
    path.write_text(
        f"""
        [router]
        rights = ["read"]
        [[target]]
        host = "192.168.1.5"
        [[target]]
        host = "192.168.1.6"
        name = "mill"
        user = "you"
        password = "2"
        net_id = "5.1.1.1.1.1"
        tls = {{fingerprint = "{fingerprint}"}}
        """
    )
    config = configuration_of(
        path, ["10.0.0.1"], net_id="5.7.7.7.1.1", host="127.0.0.9", user="me", password="1"
    )
    assert (str(config.router.net_id), config.router.host) == ("5.7.7.7.1.1", "127.0.0.9")
    press, mill, further = config.target
    assert (further.host, press.user, mill.user, mill.password) == ("10.0.0.1", "me", "you", "2")
    assert (press.title, press.net_id, press.endpoint) == (
        "192.168.1.5",
        None,
        ("192.168.1.5", 48898),
    )
    assert (mill.title, mill.endpoint) == ("mill", ("192.168.1.6", 8016))
    assert mill.net_id is not None
    tls = mill.route(mill.net_id).tls
    assert tls is not None
    assert (tls.kind, tls.fingerprint) == (TlsKind.SELF_SIGNED, fingerprint)


@pytest.mark.parametrize(
    ("table", "fault"),
    [("resubscribe = true", "expected host, net_id or both"), ('host = "10.0.0.1"', "resubscribe")],
)
def test_rule_for_programs_says_which_and_what(table: str, fault: str, tmp_path: Path) -> None:
    path = tmp_path / "router.toml"
    path.write_text(f"[[client]]\n{table}\n")
    with pytest.raises(ConfigError, match=fault):
        configuration_of(path, ["press"])


def test_target_of_a_command_line_may_name_its_net_id() -> None:
    press, mill = configuration_of(None, ["press", "mill:48900=5.1.2.3.1.1"]).target
    assert (press.net_id, str(mill.net_id)) == (None, "5.1.2.3.1.1")


@pytest.mark.parametrize(
    ("text", "fault"),
    [("=5.1.2.3.1.1", "host"), ("press=5.1", "net_id: a NetId"), ("press:x", "a TCP port")],
)
def test_target_that_cannot_be_is_refused(text: str, fault: str) -> None:
    with pytest.raises(ConfigError, match=fault):
        configuration_of(None, [text])


def test_targets_are_unique(tmp_path: Path) -> None:
    path = tmp_path / "router.toml"
    path.write_text('[[target]]\nhost = "a"\n[[target]]\nhost = "a"\n')
    with pytest.raises(ConfigError, match=r"target\.name: each once, got a"):
        configuration_of(path)
    path.write_text('[[target]]\nhost = "a"\n[[axis]]\nid = 1\n')
    with pytest.raises(ConfigError, match="axis: no such key"):
        configuration_of(path)


def test_router_without_targets_is_refused() -> None:
    with pytest.raises(ConfigError, match="no target: expected --to HOST"):
        configuration_of(None)
