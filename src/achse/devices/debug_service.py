"""Debugging service: JSON requests to the debugger of a PLC."""

import json
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from achse.iec import ArrayType, StructType, resolved
from achse.plc import PlcRuntime
from achse.plc.debug import Breakpoint, DebugError, Debugger, StepKind
from achse.plc.debug.evaluate import EvaluationError, assign, evaluate, is_expandable, text_of
from achse.plc.debug.places import DebugSpot, NotThere

_LONGEST_REQUEST = 1 << 16
_MOST_PARTS = 500
"""Variables in one answer."""

Fields = Mapping[str, Any]


Attached = Callable[[bytes, int], object]
"""Called with a client and the AMS port of a PLC."""


class DebuggedStation(Protocol):
    """Interface of the station to the debugging group."""

    @property
    def plcs(self) -> Mapping[int, PlcRuntime]: ...

    def source_files(self, port: int) -> Mapping[str, str]:
        """Return the paths of a PLC's own source files, by the names that faults use."""
        ...


class DebugService:
    """Answers for all PLCs of a station."""

    def __init__(self, station: DebuggedStation, attached: Attached) -> None:
        self._station = station
        self._attached = attached
        self._client = b""
        self._does: Mapping[str, Callable[[int, PlcRuntime, Fields], Any]] = {
            "state": lambda port, plc, fields: _state(plc),
            "break": self._break,
            "set_breaks": self._set_breaks,
            "breaks": lambda port, plc, fields: _breaks(plc),
            "clear": self._clear,
            "attach": self._attach,
            "exceptions": self._exceptions,
            "go": lambda port, plc, fields: self._go(plc, lambda of: of.go()),
            "step": self._step,
            "pause": self._pause,
            "calls": self._calls,
            "variables": self._variables,
            "evaluate": self._evaluate,
            "set": self._set,
            "source": self._source,
            "files": lambda port, plc, fields: dict(self._station.source_files(port)),
            "end": self._end,
        }

    def _plc(self, offset: int) -> tuple[int, PlcRuntime]:
        plcs = self._station.plcs
        if not plcs:
            raise DebugError("this station has no PLC")
        port = offset or next(iter(plcs))
        if port not in plcs:
            raise DebugError(f"port {port} is not a PLC of this station")
        return port, plcs[port]

    def state(self, offset: int) -> bytes:
        """Return the state of a PLC."""
        try:
            return _json(_state(self._plc(offset)[1]))
        except DebugError as refusal:
            return _json({"error": str(refusal)})

    def answer(self, offset: int, data: bytes, client: bytes) -> bytes:
        """Do what a request says; what cannot be done is an object with `error`."""
        self._client = client
        try:
            port, plc = self._plc(offset)
            if len(data) > _LONGEST_REQUEST:
                raise DebugError(f"a request has at most {_LONGEST_REQUEST} bytes")
            fields = json.loads(data.rstrip(b"\0"))
            if not isinstance(fields, dict):
                raise DebugError(f"a request is a JSON object, got {type(fields).__name__}")
            do = self._does.get(str(fields.get("do")))
            if do is None:
                raise DebugError(f"do: one of {', '.join(self._does)}; got {fields.get('do')!r}")
            result = do(port, plc, fields)
        except (DebugError, EvaluationError, NotThere) as refusal:
            return _json({"error": str(refusal)})
        except (ValueError, RecursionError) as failure:
            return _json({"error": f"no JSON: {failure}"})
        return _json(result)

    # what can be done ------------------------------------------------------------------------

    def _debugger(self, port: int, plc: PlcRuntime) -> Debugger:
        was_there = plc.debugger is not None
        debugger = plc.debug()
        if not was_there:
            debugger.own_paths = frozenset(self._station.source_files(port))
        return debugger

    def _break(self, port: int, plc: PlcRuntime, fields: Fields) -> Any:
        return _facts(
            self._debugger(port, plc).add(
                _text(fields, "path"),
                _number(fields, "line"),
                _text(fields, "condition", ""),
                _number(fields, "hits", 0),
            )
        )

    def _set_breaks(self, port: int, plc: PlcRuntime, fields: Fields) -> Any:
        """Return all breakpoints of one file at once."""
        path, wanted = _text(fields, "path"), fields.get("breaks")
        if not isinstance(wanted, list) or not all(isinstance(one, dict) for one in wanted):
            raise DebugError("breaks: a list of objects with `line`")
        debugger = self._debugger(port, plc)
        mine = path.replace("\\", "/").lower()
        debugger.clear(
            [
                number
                for number, one in debugger.breakpoints.items()
                if one.path.replace("\\", "/").lower() == mine
            ]
        )
        return [self._break(port, plc, {**one, "path": path}) for one in wanted]

    def _clear(self, port: int, plc: PlcRuntime, fields: Fields) -> Any:
        if plc.debugger is not None:
            number = _number(fields, "number", 0)
            if number and number not in plc.debugger.breakpoints:
                raise DebugError(f"no breakpoint has the number {number}")
            plc.debugger.clear([number] if number else None)
        return _breaks(plc)

    def _attach(self, port: int, plc: PlcRuntime, fields: Fields) -> Any:
        """Debugging ends with the connection of this client."""
        self._debugger(port, plc)
        self._attached(self._client, port)
        return _state(plc)

    def _exceptions(self, port: int, plc: PlcRuntime, fields: Fields) -> Any:
        debugger = self._debugger(port, plc)
        debugger.breaks_on_exceptions = bool(fields.get("on", True))
        debugger.skips_libraries = bool(fields.get("skip_libraries", debugger.skips_libraries))
        return _state(plc)

    def _go(self, plc: PlcRuntime, act: Callable[[Debugger], object]) -> Any:
        if plc.debugger is None:
            raise DebugError("no cycle is halted")
        act(plc.debugger)
        return _state(plc)

    def _step(self, port: int, plc: PlcRuntime, fields: Fields) -> Any:
        try:
            how = StepKind(_text(fields, "how", StepKind.OVER.value))
        except ValueError:
            raise DebugError("how: into, over or out") from None
        return self._go(plc, lambda of: of.step(how))

    def _pause(self, port: int, plc: PlcRuntime, fields: Fields) -> Any:
        self._debugger(port, plc).pause()
        return _state(plc)

    def _end(self, port: int, plc: PlcRuntime, fields: Fields) -> Any:
        plc.end_debugging()
        return _state(plc)

    # looking ---------------------------------------------------------------------------------

    def _calls(self, port: int, plc: PlcRuntime, fields: Fields) -> Any:
        files = self._station.source_files(port)
        return [
            {
                "number": call.number,
                "routine": call.routine.name,
                "path": call.path,
                "file": files.get(call.path, ""),
                "line": call.line,
                "place": call.place,
                "library": call.is_library,
            }
            for call in (plc.debugger.calls() if plc.debugger is not None else ())
        ]

    def _variables(self, port: int, plc: PlcRuntime, fields: Fields) -> Any:
        """Of a scope (`locals`, `instance`, `unit`, or a list's name), or parts of a variable."""
        debugger = self._debugger(port, plc)
        view = debugger.view(_number(fields, "call", 0))
        names = debugger.names
        of = _text(fields, "of", "")
        start, count = _number(fields, "start", 0), _number(fields, "count", _MOST_PARTS)
        if of:
            spot = evaluate(of, names, view)
            if not isinstance(spot, DebugSpot):
                raise DebugError(f"{of} has no parts")
            count = min(max(count, 0), _MOST_PARTS)
            parts = list(names.children(spot, max(start, 0), count))
            return [_variable(part, _path(of, spot, part)) for part in parts]
        scope = _text(fields, "scope", "locals")
        if scope in ("locals", "instance"):
            if view is None:
                raise DebugError("no cycle is halted")
            spots = names.locals(view) if scope == "locals" else names.instance(view)
            prefix = "" if scope == "locals" else "THIS^."
        elif scope == "unit":
            if view is None:
                raise DebugError("no cycle is halted")
            owner = view.routine.owner or view.routine.key
            spots, prefix = names.unit(owner), f"{owner}."
        elif scope == "lists":
            return [
                {"name": name, "type": "VAR_GLOBAL", "value": "", "path": name, "parts": True}
                for name in names.lists
            ]
        else:
            spots, prefix = names.unit(scope), f"{scope}."
            if not spots:
                raise DebugError(f"no program or list is named {scope!r}, or it has no variables")
        return [_variable(spot, f"{prefix}{spot.name}") for spot in spots[:_MOST_PARTS]]

    def _evaluate(self, port: int, plc: PlcRuntime, fields: Fields) -> Any:
        debugger = self._debugger(port, plc)
        text = _text(fields, "expression")
        result = evaluate(text, debugger.names, debugger.view(_number(fields, "call", 0)))
        if isinstance(result, DebugSpot):
            return {**_variable(result, text), "name": text}
        return {"name": text, "type": "", "value": text_of(result), "path": "", "parts": False}

    def _set(self, port: int, plc: PlcRuntime, fields: Fields) -> Any:
        debugger = self._debugger(port, plc)
        target = _text(fields, "target")
        view = debugger.view(_number(fields, "call", 0))
        return _variable(assign(target, _text(fields, "value"), debugger.names, view), target)

    def _source(self, port: int, plc: PlcRuntime, fields: Fields) -> Any:
        """Return the text of a source, those of libraries too."""
        path = _text(fields, "path")
        routines = () if plc.bodies is None else plc.bodies.project.routines.values()
        for routine in routines:
            if routine.source.path == path:
                return {"path": path, "text": routine.source.text}
        raise DebugError(f"no source is named {path!r}")


def _state(plc: PlcRuntime) -> dict[str, Any]:
    debugger = plc.debugger
    state: dict[str, Any] = {
        "plc": plc.name,
        "port": plc.port,
        "state": "halted" if plc.is_halted else plc.state.value,
        "debugging": debugger is not None,
        "changes": 0 if debugger is None else debugger.changes,
        "tasks": [task.name for task in plc.tasks],
        "fault": "" if plc.fault is None else str(plc.fault),
    }
    stop = None if debugger is None else debugger.stop
    if stop is not None:
        state["stop"] = {
            "number": stop.number,
            "reason": stop.reason.value,
            "task": stop.task,
            "routine": stop.routine,
            "path": stop.path,
            "line": stop.line,
            "place": stop.place,
            "text": stop.text,
            "breakpoints": list(stop.breakpoints),
        }
    return state


def _breaks(plc: PlcRuntime) -> list[dict[str, Any]]:
    debugger = plc.debugger
    return [] if debugger is None else [_facts(one) for one in debugger.breakpoints.values()]


def _facts(breakpoint: Breakpoint) -> dict[str, Any]:
    return {
        "number": breakpoint.number,
        "path": breakpoint.found_path or breakpoint.path,
        "line": breakpoint.found_line or breakpoint.line,
        "place": breakpoint.found_place,
        "condition": breakpoint.condition,
        "found": breakpoint.is_found,
        "message": breakpoint.message,
        "hits": breakpoint.hits,
    }


def _variable(spot: DebugSpot, path: str) -> dict[str, Any]:
    real = resolved(spot.type)
    count = real.count if isinstance(real, ArrayType) else 0
    if isinstance(real, StructType):
        count = len(real.members)
    return {
        "name": spot.name,
        "type": spot.type.name,
        "value": text_of(spot),
        "path": path,
        "parts": is_expandable(spot),
        "count": count,
        "indexed": isinstance(real, ArrayType),
    }


def _path(of: str, spot: DebugSpot, part: DebugSpot) -> str:
    """Return the expression that names a part of the variable `of`."""
    real = resolved(spot.type)
    if isinstance(real, ArrayType):
        return f"{of}{part.name}"
    return f"{of}.{part.name}" if isinstance(real, StructType) else f"{of}^"


def _text(fields: Fields, name: str, default: str | None = None) -> str:
    value = fields.get(name, default)
    if not isinstance(value, str):
        raise DebugError(f"{name}: a text, got {value!r:.80}")
    return value


def _number(fields: Fields, name: str, default: int | None = None) -> int:
    value = fields.get(name, default)
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 1 << 31:
        raise DebugError(f"{name}: a number from 0, got {value!r:.80}")
    return value


def _json(document: Any) -> bytes:
    return json.dumps(document).encode()
