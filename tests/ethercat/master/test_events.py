"""Events: emergencies taken apart."""

from hypothesis import given
from hypothesis import strategies as st

from achse.ethercat.master.events import EmergencyMessage


def test_an_emergency_has_code_register_and_the_makers_bytes() -> None:
    message = EmergencyMessage.decode(b"\x21\x43\x05hello")
    assert message == (0x4321, 5, b"hello")


@given(st.binary(max_size=20))
def test_any_length_is_taken(data: bytes) -> None:
    assert len(EmergencyMessage.decode(data).data) == 5
