"""Where the documentation tells of a code; that the anchors are there: tests/docs/test_site.py."""

import pytest

from achse.codes.links import code_link, library_link, service_link


@pytest.mark.parametrize(
    ("code", "link"),
    [
        (0x4655, "reference/0x4655/"),
        (0x745, "reference/0x745/"),
        (0xFFFF_FFFE, None),
    ],
)
def test_a_code_has_its_page(code: int, link: str | None) -> None:
    assert code_link(code) == link


def test_services_and_blocks() -> None:
    assert service_link(501, 0x4101, 0xA) == "reference/services-501/#0x4101-0xA"
    assert library_link("tcnc", "AXFNC") == "reference/plc-library-tcnc/#AXFNC"
