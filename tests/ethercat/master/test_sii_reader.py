"""SII images: those we make, and any bytes at all."""

from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat import Loopback, build_sii, describe
from achse.ethercat.description import OPERATION_MODES, SiiUse
from achse.ethercat.master.sii_reader import read_sii


def test_what_we_write_is_read() -> None:
    description = describe(Loopback(4, "A box", serial_number=77))
    content = read_sii(build_sii(description, alias=5))
    assert content.valid
    assert (content.alias, content.name, content.serial_number) == (5, "A box", 77)
    assert content.has_coe
    assert content.complete_access
    assert content.mailbox_out == description.layout.mailbox_out
    assert [each.use for each in content.sync_managers] == [
        SiiUse.MAILBOX_OUT,
        SiiUse.MAILBOX_IN,
        SiiUse.OUTPUTS,
        SiiUse.INPUTS,
    ]
    assert tuple(content.rx_pdos) == description.rx_pdos
    assert tuple(content.tx_pdos) == description.tx_pdos
    assert [each.assign_activate for each in content.modes] == [
        each.assign_activate for each in OPERATION_MODES
    ]
    assert content.damage == ""


def test_a_cut_image_gives_what_is_before_the_cut() -> None:
    image = build_sii(describe(Loopback(4, "A box")))
    content = read_sii(image[:0xC0])
    assert content.product_code == Loopback().identity.product_code
    assert "behind the image" in content.damage
    assert read_sii(b"").damage == "0 bytes, the head has 128"


@given(image=st.binary(max_size=300), pick=st.integers(0, 4000), size=st.integers(0, 4096))
def test_any_bytes_are_read(image: bytes, pick: int, size: int) -> None:
    read_sii(image)
    good = build_sii(describe(Loopback()))
    read_sii((good[:pick] + image + good[pick + len(image) :])[:size])
