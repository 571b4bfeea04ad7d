"""Users: hashes as text, who may, and that nothing is cheap to guess."""

import pytest

from achse.router.access import _MAX_MEMORY, PasswordHash, Users, hash_password
from achse.router.rights import ALL_RIGHTS, Right


def test_only_the_right_password_of_a_known_user_passes() -> None:
    users = Users({"Administrator": hash_password("1")})
    assert users.check("administrator", "1")
    assert not users.check("Administrator", "2")
    assert not users.check("nobody", "1")
    assert not users.check("", "")


def test_unknown_user_is_refused_with_a_password_of_no_user() -> None:
    users = Users({"Administrator": hash_password("1")})
    users._nobody = hash_password("2")
    assert not users.check("stranger", "2")


def test_users_have_their_rights_or_all() -> None:
    users = Users({}, {"Panel": Right.READ})
    assert users.rights("PANEL") == Right.READ
    assert users.rights("Administrator") == ALL_RIGHTS


def test_without_users_no_client_is_permitted() -> None:
    assert not Users()
    assert not Users().check("Administrator", "1")


def test_a_hash_survives_its_text_and_does_not_show_the_password() -> None:
    hashed = hash_password("geheim °")
    assert "geheim" not in str(hashed)
    assert PasswordHash.parse(str(hashed)) == hashed
    assert PasswordHash.parse(str(hashed)).matches("geheim °")


def test_equal_passwords_have_different_hashes() -> None:
    assert hash_password("1") != hash_password("1")
    assert len(hash_password("1").salt) == 16


def test_the_hash_is_scrypt_as_rfc_7914_has_it() -> None:
    """The third test vector of RFC 7914 §12, N=16384, r=8, p=1, the first 32 bytes."""
    expected = "7023bdcb3afd7348461c06cd81fd38ebfda8fbba904f8e3ea9b543f6545da1f2"
    assert hash_password("pleaseletmein", b"SodiumChloride").key.hex() == expected


@pytest.mark.parametrize(
    "text",
    [
        "",
        "1",
        "scrypt:16384:8:1:AAAA",
        "md5:16384:8:1:AAAA:AAAA",
        "scrypt:x:8:1:AAAA:AAAA",
        "scrypt:16384:8:1:A:AAAA",
        "scrypt:16383:8:1:AAAA:AAAA",
        "scrypt:16384:8:1:AAAA:",
        "scrypt:16384:0:1:AAAA:AAAA",
        "scrypt:1048576:8:1:AAAA:AAAA",
        "scrypt:2:262144:5:AAAA:AAAA",
        "scrypt:1:1:1:AAAA:AAAA",
        "scrypt:16384:8:1:AAAA:AAAA:AAAA",
    ],
)
def test_what_is_no_hash_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="password hash"):
        PasswordHash.parse(text)


def test_cost_above_the_highest_is_refused() -> None:
    with pytest.raises(ValueError, match="a power of 2 up to"):
        PasswordHash.parse("scrypt:2097152:1:1:AAAA:AAAA")


@pytest.mark.parametrize("numbers", ["2:1:1", "1048576:1:1", "2:262144:4"])
def test_least_and_greatest_hash_are_accepted(numbers: str) -> None:
    assert PasswordHash.parse(f"scrypt:{numbers}:AAAA:AAAA").cost > 0


def test_hash_that_takes_most_memory_can_be_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    """A thousandth of it within a thousandth of the limit: OpenSSL counts by its own formula."""
    greatest = PasswordHash.parse("scrypt:2:256:4:AAAA:AAAA")
    monkeypatch.setattr("achse.router.access._MAX_MEMORY", _MAX_MEMORY // 1024)
    assert not greatest.matches("1")
    with pytest.raises(ValueError, match="memory limit"):
        greatest._replace(parallel=5).matches("1")
