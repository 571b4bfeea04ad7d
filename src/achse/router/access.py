"""Users that may change the routes of this station from outside, by scrypt hashes of passwords.

The hash is `scrypt:N:R:P:SALT:KEY`, salt and key in base64; `achse hash-password` makes one.
"""

import base64
import binascii
import hashlib
import hmac
import os
from collections.abc import Mapping
from typing import NamedTuple

from achse.router.rights import ALL_RIGHTS, Right

_COST, _BLOCK, _PARALLEL = 1 << 14, 8, 1
"""16 MB and some 40 ms per check."""

_MAX_MEMORY = 256 * 1024 * 1024
_KEY_SIZE = 32


class PasswordHash(NamedTuple):
    """Scrypt hash of a password, with its parameters and salt."""

    cost: int
    block: int
    parallel: int
    salt: bytes
    key: bytes

    @classmethod
    def parse(cls, text: str) -> "PasswordHash":
        """Read `scrypt:N:R:P:SALT:KEY`; ValueError says what is wrong."""
        kind, *fields = text.split(":")
        try:
            if kind != "scrypt":
                raise ValueError
            cost, block, parallel = map(int, fields[:3])
            salt, key = (base64.b64decode(field, validate=True) for field in fields[3:])
        except (ValueError, binascii.Error):
            raise ValueError(
                "a password hash is scrypt:N:R:P:SALT:KEY as `achse hash-password` prints it"
            ) from None
        hashed = cls(cost, block, parallel, salt, key)
        if not key or cost & (cost - 1) or not 2 <= cost <= 1 << 20 or block * parallel < 1:
            raise ValueError("a password hash needs N a power of 2 up to 2^20, R, P and a key")
        if 128 * block * (cost + parallel + 2) > _MAX_MEMORY:  # as OpenSSL counts it
            raise ValueError("this password hash would take more than 256 MB per check")
        return hashed

    def __str__(self) -> str:
        salt, key = (base64.b64encode(part).decode() for part in (self.salt, self.key))
        return f"scrypt:{self.cost}:{self.block}:{self.parallel}:{salt}:{key}"

    def matches(self, password: str) -> bool:
        """Return True if `password` is right; takes as long for a wrong one."""
        return hmac.compare_digest(
            self.key,
            hashlib.scrypt(
                password.encode(),
                salt=self.salt,
                n=self.cost,
                r=self.block,
                p=self.parallel,
                maxmem=_MAX_MEMORY,
                dklen=len(self.key),
            ),
        )


def hash_password(password: str, salt: bytes | None = None) -> PasswordHash:
    """Return the hash of `password` with a salt of its own."""
    salt = os.urandom(16) if salt is None else salt
    key = hashlib.scrypt(
        password.encode(), salt=salt, n=_COST, r=_BLOCK, p=_PARALLEL, dklen=_KEY_SIZE
    )
    return PasswordHash(_COST, _BLOCK, _PARALLEL, salt, key)


class Users:
    """Users and their password hashes; names without regard to case, as on a real target."""

    def __init__(
        self,
        hashes: Mapping[str, PasswordHash] | None = None,
        rights: Mapping[str, Right] | None = None,
    ) -> None:
        self._rights = {name.casefold(): each for name, each in (rights or {}).items()}
        self._hashes = {name.casefold(): hashed for name, hashed in (hashes or {}).items()}
        self._nobody = PasswordHash(_COST, _BLOCK, _PARALLEL, bytes(16), bytes(_KEY_SIZE))

    def __bool__(self) -> bool:
        return bool(self._hashes)

    def rights(self, user: str) -> Right:
        """Return the rights of the routes that this user adds."""
        return self._rights.get(user.casefold(), ALL_RIGHTS)

    def check(self, user: str, password: str) -> bool:
        """Return True if the user exists and has that password. Takes some 40 ms: not on the
        loop."""
        hashed = self._hashes.get(user.casefold())
        # An unknown user takes as long as a wrong password.
        matches = (hashed or self._nobody).matches(password)
        return matches and hashed is not None
