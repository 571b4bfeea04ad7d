"""Messages between page and server: JSON texts, and errors as the page shows them."""

import json
import math
import os
from typing import Any

from achse.ams import AdsError
from achse.codes import code_of
from achse.codes.links import SITE, code_link, on_site


class CallError(ValueError):
    """A call that cannot be done as it was made: says what was expected and what came."""


def dumped(value: Any) -> str:
    """`value` as JSON; numbers that JSON does not have (NaN, infinity) are null."""
    try:
        return json.dumps(value, allow_nan=False, separators=(",", ":"))
    except ValueError:
        return json.dumps(_finite(value), separators=(",", ":"))


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return value


def request_of(text: str) -> tuple[int | str, str, dict[str, Any]]:
    """Id, name and arguments of a call. Raises CallError for what is not one."""
    try:
        request = json.loads(text)
    except (ValueError, RecursionError):
        raise CallError("expected a JSON object") from None
    if not isinstance(request, dict):
        raise CallError(f"expected a JSON object, got {type(request).__name__}")
    number, name, fields = request.get("id"), request.get("call"), request.get("with", {})
    if isinstance(number, bool) or not isinstance(number, int | str) or len(str(number)) > 40:
        raise CallError(f"id: expected a number or a text, got {number!r:.60}")
    if not isinstance(name, str):
        raise CallError(f"call: expected the name of a call, got {name!r:.60}")
    if not isinstance(fields, dict):
        raise CallError(f"with: expected an object, got {fields!r:.60}")
    return number, name, fields


def error_of(failure: Exception) -> dict[str, Any]:
    """Return an error as the page shows it: text, code, name, link."""
    code = getattr(failure, "code", None) if isinstance(failure, AdsError) else None
    row = None if not code else code_of(code)
    return {
        "text": str(failure) or type(failure).__name__,
        "code": code or None,
        "name": None if row is None else row.name,
        "link": on_site(code_link(code) if code else None, os.environ.get(SITE)),
    }
