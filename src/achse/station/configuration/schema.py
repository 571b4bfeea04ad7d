"""JSON schema of a station.toml for editors, made of the models that read it."""

import ast
import copy
import functools
import inspect
import math
import sys
from collections.abc import Mapping
from typing import Any, get_args

from pydantic import BaseModel

from achse.ams import NetId
from achse.faults.kinds import STATION_FAULTS
from achse.motion.nc import configurable
from achse.motion.states import choices_of
from achse.station.configuration.station_file import (
    AxisConfig,
    FaultConfig,
    StationConfig,
    axis_keys,
)
from achse.station.configuration.types import ConfigTable

_DRAFT = "http://json-schema.org/draft-07/schema#"
"""JSON schema draft that editors of TOML support."""

_ELEMENTS = ("encoder_", "controller_", "drive_", "simulation_")
"""Prefixes of the parameters of a further encoder, controller or drive."""


def station_schema() -> dict[str, Any]:
    """Return the schema of a whole station.toml: every key with type, range, default and
    meaning."""
    return copy.deepcopy(_station_schema())


@functools.cache
def _station_schema() -> dict[str, Any]:
    schema = StationConfig.model_json_schema()
    parts: dict[str, Any] = schema.pop("$defs")
    models = {model.__name__: model for model in _models(StationConfig)}
    for name, part in (*parts.items(), (StationConfig.__name__, schema)):
        for key, text in descriptions_of(models[name]).items():
            part["properties"][key].setdefault("description", text)
        for each, key in part["properties"].items():
            key.pop("title", None)
            default = models[name].model_fields[each].default
            if isinstance(default, NetId):
                key["default"] = str(default)
            _write_durations(key)
    _add_axis(parts[AxisConfig.__name__])
    _add_faults(parts[FaultConfig.__name__])
    return {"$schema": _DRAFT, **schema, "title": "station.toml", "$defs": parts}


def descriptions_of(model: type[BaseModel]) -> dict[str, str]:
    """Return the text under each key of a model; nothing where there are no sources."""
    descriptions: dict[str, str] = {}
    models = [each for each in reversed(model.__mro__) if issubclass(each, BaseModel)]
    described_by = model.described_by if issubclass(model, ConfigTable) else ()
    for each in (*described_by, *models):
        if each is not BaseModel:
            descriptions |= _texts_of(each.__module__).get(each.__qualname__, {})
    return {key: text for key, text in descriptions.items() if key in model.model_fields}


@functools.cache
def _texts_of(module: str) -> dict[str, dict[str, str]]:
    """Return the text under each annotated name of each class of a module."""
    try:
        source = inspect.getsource(sys.modules[module])
    except (OSError, TypeError):
        return {}
    classes = (each for each in ast.parse(source).body if isinstance(each, ast.ClassDef))
    return {
        each.name: {
            key.target.id: " ".join(str(text.value.value).split())
            for key, text in zip(each.body, each.body[1:], strict=False)
            if isinstance(key, ast.AnnAssign)
            and isinstance(key.target, ast.Name)
            and isinstance(text, ast.Expr)
            and isinstance(text.value, ast.Constant)
        }
        for each in classes
    }


def _models(model: type[BaseModel]) -> list[type[BaseModel]]:
    """Return a model, and those that its keys name."""
    models = [model]
    waiting = [field.annotation for field in model.model_fields.values()]
    while waiting:
        annotation: Any = waiting.pop()
        waiting.extend(get_args(annotation))
        is_model = isinstance(annotation, type) and not get_args(annotation)
        if is_model and issubclass(annotation, BaseModel) and annotation not in models:
            models += [inner for inner in _models(annotation) if inner not in models]
    return models


def _write_durations(key: dict[str, Any]) -> None:
    """Write a default in nanoseconds as a file has it."""
    ways = [key, *key.get("anyOf", ())]
    default = key.get("default")
    if isinstance(default, int) and any("2ms" in way.get("examples", ()) for way in ways):
        key["default"] = "0s" if not default else f"{default / 1e6:g}ms"
    if key.get("default", 0) is None:
        del key["default"]  # TOML has no null: the key is left out
        key["anyOf"] = [way for way in key["anyOf"] if way != {"type": "null"}]


def _add_axis(axis: dict[str, Any]) -> None:
    parameters = {name: _parameter(name) for name in axis_keys()}
    axis["properties"] |= parameters
    axis["additionalProperties"] = False
    axis["properties"]["element"]["items"] = {
        "type": "object",
        "properties": {n: row for n, row in parameters.items() if n.startswith(_ELEMENTS)},
        "additionalProperties": False,
    }


def _parameter(name: str) -> dict[str, Any]:
    """Return a parameter of an axis: a number in its range, or the word of a choice, or a flag."""
    field = configurable(name)
    assert field is not None
    number: dict[str, Any] = {"type": "number"}
    bounds = {"minimum": field.least, "maximum": field.most}
    number |= {bound: value for bound, value in bounds.items() if math.isfinite(value)}
    ways = [number]
    choices = choices_of(field.unit)
    if choices is not None:
        words = [word for each in choices.__members__ for word in (each.lower(), each)]
        ways.append({"type": "string", "enum": words})
    if field.unit == "0/1":
        ways.append({"type": "boolean"})
    unit = "" if field.unit in ("1", "0/1") or choices is not None else f" [{field.unit}]"
    facts: dict[str, Any] = {"description": f"{field.doc}{unit}"}
    if isinstance(field.default, (int, float)) and math.isfinite(field.default):
        facts["default"] = field.default
    return facts | (number if len(ways) == 1 else {"anyOf": ways})


def _add_faults(fault: dict[str, Any]) -> None:
    """Add a shape for each kind of fault, with its fields and no others."""
    common: Mapping[str, Any] = fault.pop("properties")
    fault.pop("additionalProperties", None)
    fault["type"] = "object"
    fault["oneOf"] = [
        {
            "description": STATION_FAULTS.description(kind),
            "properties": {
                "kind": {"const": kind},
                "at": common["at"],
                **{
                    name: common.get(name) or {"type": type}
                    for name, type in STATION_FAULTS.types(kind).items()
                },
            },
            "required": ["kind"],
            "additionalProperties": False,
        }
        for kind in STATION_FAULTS
    ]
