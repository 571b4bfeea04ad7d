"""Identity of a drive, object 1018h: achse's own by default, that of the manual on request.

The manual prints the vendor id and product code of its drives (001 §3.1, 1018h). Files and devices
of achse do not carry the numbers of a maker unless the user configures them.
"""

from dataclasses import dataclass

VENDOR = 0xFFFF_AC5E
"""Vendor id of achse's drives. It is assigned to no maker: ETG assigns numbers from below."""

PRODUCT = 0x402
"""Product code of achse's drives: the number of their profile."""

MANUAL_VENDOR, MANUAL_PRODUCT = 0xAAAA, 0x05
"""Vendor id and product code as the manual prints them (001 §3.1, object 1018h)."""


@dataclass(frozen=True, slots=True)
class DriveIdentity:
    """Object 1018h."""

    vendor_id: int = VENDOR
    product_code: int = PRODUCT
    revision_number: int = 0x0001_0000
    serial_number: int = 1


IDENTITIES = {
    "achse": DriveIdentity(),
    "manual": DriveIdentity(MANUAL_VENDOR, MANUAL_PRODUCT),
}
"""Identities by the word in `station.toml` and on the command line."""
