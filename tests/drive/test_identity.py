"""Identity of a drive: numbers of no maker by default, those of the manual on request."""

from achse.drive import IDENTITIES, Drive
from achse.drive.identity import MANUAL_PRODUCT, MANUAL_VENDOR, PRODUCT, VENDOR
from achse.ethercat import build_sii, describe
from achse.ethercat.esi import build_esi

ASSIGNED_BELOW = 0x1000_0000
"""ETG assigns vendor ids from below; its list ends far before this one."""


def test_default_identity_belongs_to_no_maker() -> None:
    assert VENDOR >= ASSIGNED_BELOW
    drive = Drive()
    assert [drive.get(0x1018, n) for n in (1, 2)] == [VENDOR, PRODUCT]


def test_files_carry_the_identity_of_the_drive_alone() -> None:
    number = (MANUAL_VENDOR).to_bytes(4, "little")
    for name, identity in IDENTITIES.items():
        description = describe(Drive(identity=identity))
        image, text = build_sii(description), build_esi(description, vendor="achse")
        is_manual = name == "manual"
        assert (image[16:20] == number) is is_manual
        assert (f"#x{MANUAL_VENDOR:08X}" in text) is is_manual
        assert (identity.product_code == MANUAL_PRODUCT) is is_manual
