"""Validation of configuration files: each error names the file, the key and what was expected."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from achse.iec.nearest import did_you_mean
from achse.station.configuration.documents import check_depth, parse_toml
from achse.station.configuration.types import ConfigError, without_plugins

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

Table = TypeVar("Table", bound=BaseModel)

_FEW_KEYS = 12
"""So many keys of a table are listed whole."""


def document_of(path: Path) -> dict[str, Any]:
    """Return the document of a TOML file. Raises ConfigError; OSError if it cannot be read."""
    try:
        return parse_toml(path.read_text(encoding="utf-8-sig"))  # editors begin with a mark
    except UnicodeDecodeError as failure:
        raise ConfigError(
            f"{path}: not UTF-8, byte {failure.start + 1} is 0x{failure.object[failure.start]:02X};"
            " save it as UTF-8"
        ) from None
    except ValueError as failure:
        raise ConfigError(f"{path}: no valid TOML: {failure}") from None


def validated(
    model: type[Table],
    document: dict[str, Any],
    source: str,
    kinds: Mapping[str, Sequence[str]] = {},
) -> Table:
    """Validate a parsed document as `model`; `source` names it in errors. Raises ConfigError.

    `kinds` lists the values of the key `kind` for each table that has several kinds.
    """
    try:
        check_depth(document)
    except ValueError as fault:
        raise ConfigError(f"{source}: {fault}") from None
    try:
        with without_plugins():
            return model.model_validate(document)
    except ValidationError as failure:
        lines = [f"{source}: {_message(model, error, kinds)}" for error in failure.errors()]
        raise ConfigError("\n".join(lines)) from None


_EXPECTED = {
    "string_type": "expected a text",
    "bool_type": "expected true or false",
    "bool_parsing": "expected true or false",
    "int_type": "expected a whole number",
    "int_parsing": "expected a whole number",
    "int_from_float": "expected a whole number",
    "float_type": "expected a number",
    "float_parsing": "expected a number",
    "finite_number": "expected a finite number",
    "literal_error": "expected {expected}",
    "greater_than": "expected more than {gt}",
    "greater_than_equal": "expected {ge} or more",
    "less_than": "expected less than {lt}",
    "less_than_equal": "expected {le} or less",
    "too_long": "expected at most {max_length} of them",
    "too_short": "expected at least {min_length} of them",
}
"""Description of a valid value, by the kind of error that pydantic reports."""


def _message(
    model: type[BaseModel], error: "ErrorDetails", kinds: Mapping[str, Sequence[str]]
) -> str:
    """Return key, expectation and what came."""
    place = list(error["loc"])
    of_table = kinds.get(str(place[0]), ()) if place else ()
    if of_table and len(place) > 2:
        del place[2]  # the kind, by which pydantic names the table
    expected = error["msg"].removeprefix("Value error, ")
    received = "" if error["type"] == "missing" else f", got {error['input']!r:.80}"
    if error["type"] == "missing":
        expected = "expected, but not there"
    elif error["type"] == "extra_forbidden":
        expected, received = (
            f"no such key{_instead(str(place[-1]), _keys_of(model, error['loc']))}",
            "",
        )
    elif error["type"] in _EXPECTED:
        limits = {
            name: int(value) if isinstance(value, float) and value.is_integer() else value
            for name, value in error.get("ctx", {}).items()
        }
        expected = _EXPECTED[error["type"]].format(**limits)
    elif error["type"] in ("model_type", "model_attributes_type", "dict_type"):
        expected = "expected a table"
    elif error["type"] in ("is_instance_of", "tuple_type", "list_type"):
        expected = "expected a list"
        if isinstance(error["input"], dict):  # [axis] where [[axis]] was meant
            names = ".".join(str(part) for part in place if isinstance(part, str))
            expected = f"there may be several: write [[{names}]]"
    elif error["type"].startswith("union_tag"):
        place.append("kind")
        kind = error["input"].get("kind") if isinstance(error["input"], dict) else None
        expected = f"one of {', '.join(of_table)}"
        received = "" if kind is None else f", got {kind!r:.80}{did_you_mean(str(kind), of_table)}"
    key = ""
    for part in place:
        key += f"[{part + 1}]" if isinstance(part, int) else f"{'.' * bool(key)}{part}"
    if received in expected or " got " in expected or not key:
        received = ""
    return f"{key + ': ' * bool(key)}{expected}{received}"


def _instead(key: str, known: list[str]) -> str:
    """Return a hint to the key that may be meant; to all keys where none is near and there are
    few."""
    few = len(known) <= _FEW_KEYS
    return did_you_mean(key, known) or (f"; there are {', '.join(known)}" if few else "")


def _keys_of(model: type[BaseModel], place: Sequence[int | str]) -> list[str]:
    """Return the keys of the table in which an unknown key is."""
    models: list[type[BaseModel]] = [model]
    for part in place[:-1]:
        if isinstance(part, int):
            continue
        tagged = [each for each in models if _kind_of(each) == part]
        if tagged:
            models = tagged
            continue
        models = [
            inner
            for each in models
            if part in each.model_fields
            for inner in _models_in(each.model_fields[part].annotation)
        ]
    return [key for each in models for key in each.model_fields]


def _kind_of(model: type[BaseModel]) -> str | None:
    """Return the value of `kind` for a model that is one of several."""
    kind = model.model_fields.get("kind")
    return next(iter(get_args(kind.annotation)), None) if kind is not None else None


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    """Return the models that a key's type names."""
    if parts := get_args(annotation):
        return [model for part in parts for model in _models_in(part)]
    is_model = isinstance(annotation, type) and issubclass(annotation, BaseModel)
    return [annotation] if is_model else []
