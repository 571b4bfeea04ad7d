"""Settings of a web server: their ranges."""

import pytest

from achse.extras import install_command
from achse.web.settings import WebExtraMissing, WebSettings


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"port": 70_000}, "web port: expected 0..65535, got 70000"),
        ({"viewers": 0}, "web viewers: expected 1 or more, got 0"),
        ({"token": "ä"}, "web token: expected letters and digits"),
    ],
)
def test_what_cannot_be_is_refused(settings: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        WebSettings(**settings)  # type: ignore[arg-type]


def test_the_extra_is_named() -> None:
    assert install_command("web") in str(WebExtraMissing())
