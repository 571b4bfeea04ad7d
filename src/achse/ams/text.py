"""Texts in data of ADS services: cp1252, ended by a NUL.

Source: recorded traffic of TwinCAT 3.1 routers and targets.
"""


def terminated_text(data: bytes) -> str:
    """Return the text before the first NUL, or all of it without one; a byte that is not cp1252
    becomes U+FFFD."""
    return data.partition(b"\0")[0].decode("cp1252", "replace")
