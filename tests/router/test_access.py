"""Users: hashes as text, who may, and that nothing is cheap to guess."""

import pytest

from achse.router.access import PasswordHash, Users, hash_password


def test_only_the_right_password_of_a_known_user_passes() -> None:
    users = Users({"Administrator": hash_password("1")})
    assert users.check("administrator", "1")
    assert not users.check("Administrator", "2")
    assert not users.check("nobody", "1")
    assert not users.check("", "")


def test_without_users_nobody_may() -> None:
    assert not Users()
    assert not Users().check("Administrator", "1")


def test_a_hash_survives_its_text_and_does_not_show_the_password() -> None:
    hashed = hash_password("geheim °")
    assert "geheim" not in str(hashed)
    assert PasswordHash.parse(str(hashed)) == hashed
    assert PasswordHash.parse(str(hashed)).matches("geheim °")


def test_equal_passwords_have_different_hashes() -> None:
    assert hash_password("1") != hash_password("1")


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
    ],
)
def test_what_is_no_hash_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="password hash"):
        PasswordHash.parse(text)
