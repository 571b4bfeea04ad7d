"""The adapter: what an editor asks by the Debug Adapter Protocol, asked of a station.

Tasks are the editor's threads. A halted cycle halts all tasks of its PLC, so all of
them are stopped then.
"""

import asyncio
import contextlib
import logging
from collections.abc import Awaitable, Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from achse.ams import AdsError
from achse.dap.link import DebugRefused
from achse.dap.target import Target, TargetError
from achse.station import ConfigError

Send = Callable[[dict[str, Any]], None]
Arguments = Mapping[str, Any]

_POLL = 0.05
"""Seconds between looks at a station that runs."""

_MOST_REFERENCES = 100_000
_EXCEPTIONS = "plc"

_CAPABILITIES: dict[str, Any] = {
    "supportsConfigurationDoneRequest": True,
    "supportsConditionalBreakpoints": True,
    "supportsHitConditionalBreakpoints": True,
    "supportsEvaluateForHovers": True,
    "supportsSetVariable": True,
    "supportsSetExpression": True,
    "supportsExceptionInfoRequest": True,
    "supportsDelayedStackTraceLoading": True,
    "supportsTerminateRequest": True,
    "supportTerminateDebuggee": True,
    "exceptionBreakpointFilters": [
        {
            "filter": _EXCEPTIONS,
            "label": "PLC exceptions",
            "description": "Stop where an exception of the PLC is raised",
            "default": True,
        }
    ],
}


class _Refused(Exception):
    """A request that cannot be answered; the message says why."""


class _Reference(NamedTuple):
    """Reference that the editor has as a number: a scope of a call, or the parts of a variable."""

    call: int
    scope: str = ""
    path: str = ""


class Adapter:
    """One editor. `send` takes messages for it; `handle` its messages, one after the other."""

    def __init__(self, send: Send) -> None:
        self._send_message = send
        self._sequence = 0
        self._target: Target | None = None
        self._watcher: asyncio.Task[None] | None = None
        self._references: dict[int, _Reference] = {}
        self._library_sources: dict[int, str] = {}
        self._client_paths: dict[str, str] = {}
        """Editor's path of a file, by the file's real path."""
        self._tasks: list[str] = []
        self._reported = 0
        """The number of the last stop that the editor knows of."""
        self._is_stopped = False
        self._told_fault = ""
        self._entry = False
        self._logs: _Logs | None = None
        self.is_over = False
        """The editor has gone."""
        self._does: Mapping[str, Callable[[Arguments], Awaitable[Any]]] = {
            "initialize": self._initialize,
            "launch": lambda arguments: self._open(arguments, launch=True),
            "attach": lambda arguments: self._open(arguments, launch=False),
            "configurationDone": self._configuration_done,
            "setBreakpoints": self._set_breakpoints,
            "setFunctionBreakpoints": self._no_breakpoints,
            "setExceptionBreakpoints": self._set_exception_breakpoints,
            "threads": self._threads,
            "stackTrace": self._stack_trace,
            "scopes": self._scopes,
            "variables": self._variables,
            "setVariable": self._set_variable,
            "setExpression": self._set_expression,
            "evaluate": self._evaluate,
            "source": self._source,
            "exceptionInfo": self._exception_info,
            "continue": lambda arguments: self._go("go"),
            "next": lambda arguments: self._go("step", how="over"),
            "stepIn": lambda arguments: self._go("step", how="into"),
            "stepOut": lambda arguments: self._go("step", how="out"),
            "pause": self._pause,
            "disconnect": self._disconnect,
            "terminate": self._disconnect,
        }
        self._after: list[Callable[[], Awaitable[None]]] = []
        """Actions to run after the answer is sent."""

    # messages --------------------------------------------------------------------------------

    def _send(self, kind: str, **fields: Any) -> None:
        self._sequence += 1
        self._send_message({"seq": self._sequence, "type": kind, **fields})

    def _event(self, event: str, **body: Any) -> None:
        self._send("event", event=event, body=body)

    async def handle(self, message: Any) -> None:
        """Answer a message. What is not a request is passed over."""
        if not isinstance(message, dict) or message.get("type") != "request":
            return
        command, number = message.get("command"), message.get("seq")
        answer = {
            "request_seq": number if isinstance(number, int) else 0,
            "command": command if isinstance(command, str) else "",
        }
        arguments = message.get("arguments")
        try:
            do = self._does.get(command) if isinstance(command, str) else None
            if do is None:
                raise _Refused(f"{command!r:.80} is not supported")
            body = await do(arguments if isinstance(arguments, dict) else {})
        except (_Refused, DebugRefused, TargetError, ConfigError, AdsError, OSError) as refusal:
            self._after.clear()
            text = str(refusal)
            self._send(
                "response",
                **answer,
                success=False,
                message=text,
                body={"error": {"id": 1, "format": text.replace("{", "(").replace("}", ")")}},
            )
            return
        self._send("response", **answer, success=True, body={} if body is None else body)
        while self._after:
            await self._after.pop(0)()

    async def close(self) -> None:
        """Note that the editor is gone: what it stopped goes on, what it launched ends."""
        self.is_over = True
        if self._logs is not None:
            logging.getLogger("achse").removeHandler(self._logs)
            self._logs = None
        watcher, self._watcher = self._watcher, None
        if watcher is not None:
            watcher.cancel()
            await asyncio.gather(watcher, return_exceptions=True)
        target, self._target = self._target, None
        if target is not None:
            if not target.is_own:
                with contextlib.suppress(AdsError, DebugRefused):
                    await target.link.request("end")
            await target.close()

    @property
    def _there(self) -> Target:
        if self._target is None:
            raise _Refused("launch or attach comes first")
        return self._target

    async def _request(self, do: str, /, **fields: Any) -> Any:
        return await self._there.link.request(do, **fields)

    # beginning and end -----------------------------------------------------------------------

    async def _initialize(self, arguments: Arguments) -> Any:
        return _CAPABILITIES

    async def _open(self, arguments: Arguments, *, launch: bool) -> None:
        if self._target is not None:
            raise _Refused("it is launched or attached already")
        target = Target(arguments, launch=launch)
        try:
            await target.open()
            await target.link.request("attach")
            await target.link.request(
                "exceptions", on=True, skip_libraries=bool(arguments.get("justMyCode", True))
            )
        except BaseException:
            await target.close()
            raise
        self._target = target
        self._tasks = list((await target.link.state())["tasks"])
        self._entry = bool(arguments.get("stopOnEntry", False))

        async def initialized() -> None:
            self._event("initialized")

        self._after.append(initialized)

    async def _configuration_done(self, arguments: Arguments) -> None:
        target = self._there
        if self._entry:
            await self._request("pause")
        if target.is_own and self._logs is None:
            self._logs = _Logs(self._log)
            logging.getLogger("achse").addHandler(self._logs)
        await target.start()
        if target.message:
            self._event("output", category="console", output=target.message)
        if self._watcher is None:
            self._watcher = asyncio.create_task(self._watch())

    async def _disconnect(self, arguments: Arguments) -> None:
        async def leave() -> None:
            await self.close()
            self._event("terminated")

        self._after.append(leave)

    async def _watch(self) -> None:
        """Send events to the editor."""
        target = self._there
        try:
            while not target.ended.is_set():
                self._notice(await target.link.state())
                await asyncio.sleep(_POLL)
        except (AdsError, DebugRefused) as failure:
            self._event("output", category="stderr", output=f"{failure}\n")
        self._event("terminated")

    def _notice(self, state: Mapping[str, Any]) -> None:
        stop = state.get("stop")
        if stop is not None and stop["number"] > self._reported:
            self._reported = stop["number"]
            self._references.clear()
            self._is_stopped = True
            entry = self._entry and stop["reason"] == "pause"
            self._entry = False
            self._event(
                "stopped",
                reason="entry" if entry else stop["reason"],
                description=f"{stop['reason']} in {stop['routine']}",
                text=stop["text"],
                threadId=self._thread_of(stop["task"]),
                allThreadsStopped=True,
                hitBreakpointIds=stop["breakpoints"],
            )
        elif stop is None and self._is_stopped:
            self._is_stopped = False
            self._references.clear()
            self._event("continued", threadId=1, allThreadsContinued=True)
        fault = str(state.get("fault", ""))
        if fault and fault != self._told_fault:
            self._event("output", category="stderr", output=f"{fault}\n")
        self._told_fault = fault

    def _thread_of(self, task: str) -> int:
        return self._tasks.index(task) + 1 if task in self._tasks else 1

    def _log(self, text: str) -> None:
        """Show what a station of its own logs: messages of programs, too."""
        self._event("output", category="stderr", output=f"{text}\n")

    # breakpoints -----------------------------------------------------------------------------

    async def _set_breakpoints(self, arguments: Arguments) -> Any:
        source = arguments.get("source")
        path = source.get("path") if isinstance(source, dict) else None
        if isinstance(source, dict) and source.get("sourceReference"):
            path = self._library_sources.get(source["sourceReference"], path)
        requested = arguments.get("breakpoints", [])
        if not isinstance(path, str) or not isinstance(requested, list):
            raise _Refused("source with a path, and a list of breakpoints")
        breaks = []
        for one in requested:
            line = one.get("line") if isinstance(one, dict) else None
            if isinstance(line, bool) or not isinstance(line, int):
                raise _Refused("a breakpoint has a line")
            hits = str(one.get("hitCondition") or "0").strip().lstrip(">=").strip()
            breaks.append(
                {
                    "line": max(line, 1),
                    "condition": str(one.get("condition") or ""),
                    "hits": int(hits) if hits.isdecimal() and len(hits) < 9 else 0,
                }
            )
        self._client_paths[_real(path)] = path
        answer = await self._request("set_breaks", path=path, breaks=breaks)
        return {
            "breakpoints": [
                {
                    "id": one["number"],
                    "verified": one["found"],
                    "line": one["line"],
                    "message": one["message"],
                    "source": source,
                }
                for one in answer
            ]
        }

    async def _no_breakpoints(self, arguments: Arguments) -> Any:
        return {"breakpoints": []}

    async def _set_exception_breakpoints(self, arguments: Arguments) -> Any:
        filters = arguments.get("filters")
        await self._request("exceptions", on=isinstance(filters, list) and _EXCEPTIONS in filters)
        return {"breakpoints": []}

    async def _exception_info(self, arguments: Arguments) -> Any:
        stop = (await self._there.link.state()).get("stop")
        if stop is None or stop["reason"] != "exception":
            raise _Refused("no exception")
        name, _, says = str(stop["text"]).partition(": ")
        return {"exceptionId": name, "description": says or name, "breakMode": "always"}

    # looking ---------------------------------------------------------------------------------

    async def _threads(self, arguments: Arguments) -> Any:
        return {
            "threads": [{"id": number, "name": task} for number, task in enumerate(self._tasks, 1)]
        }

    async def _stack_trace(self, arguments: Arguments) -> Any:
        stop = (await self._there.link.state()).get("stop")
        calls = await self._request("calls")
        if stop is None or arguments.get("threadId", 1) != self._thread_of(stop["task"]):
            calls = []
        start = _whole(arguments.get("startFrame") or 0)
        levels = _whole(arguments.get("levels") or 0) or len(calls)
        return {
            "stackFrames": [
                {
                    "id": call["number"] + 1,
                    "name": call["routine"],
                    "source": self._source_of(call),
                    "line": call["line"],
                    "column": 1,
                    **({"presentationHint": "subtle"} if call["library"] else {}),
                }
                for call in calls[start : start + levels]
            ],
            "totalFrames": len(calls),
        }

    def _source_of(self, call: Mapping[str, Any]) -> dict[str, Any]:
        name = call["path"].rpartition("/")[2]
        if call["file"]:
            return {"name": name, "path": self._client_paths.get(call["file"], call["file"])}
        for number, path in self._library_sources.items():
            if path == call["path"]:
                return {"name": name, "sourceReference": number, "origin": "library"}
        number = len(self._library_sources) + 1
        self._library_sources[number] = call["path"]
        return {"name": name, "sourceReference": number, "origin": "library"}

    async def _source(self, arguments: Arguments) -> Any:
        source = arguments.get("source")
        number = arguments.get("sourceReference") or (
            source.get("sourceReference") if isinstance(source, dict) else None
        )
        path = self._library_sources.get(number) if isinstance(number, int) else None
        if path is None:
            raise _Refused("no such source")
        return {"content": (await self._request("source", path=path))["text"]}

    def _refer(self, reference: _Reference) -> int:
        if len(self._references) >= _MOST_REFERENCES:
            raise _Refused("too many variables are open")
        number = len(self._references) + 1
        self._references[number] = reference
        return number

    async def _scopes(self, arguments: Arguments) -> Any:
        call = _whole(arguments.get("frameId", 1)) - 1
        if call < 0:
            raise _Refused("no such frame")
        scopes = []
        for scope, name in (
            ("locals", "Locals"),
            ("instance", "Instance"),
            ("unit", "Program"),
        ):
            if await self._request("variables", scope=scope, call=call):
                reference = self._refer(_Reference(call, scope))
                scopes.append({"name": name, "variablesReference": reference, "expensive": False})
        scopes.append(
            {
                "name": "Global lists",
                "variablesReference": self._refer(_Reference(call, "lists")),
                "expensive": True,
            }
        )
        return {"scopes": scopes}

    async def _parts(self, number: Any, arguments: Arguments) -> tuple[_Reference, list[Any]]:
        reference = self._references.get(number) if isinstance(number, int) else None
        if reference is None:
            raise _Refused("no such variable now")
        if reference.path:
            variables = await self._request(
                "variables",
                of=reference.path,
                call=reference.call,
                start=_whole(arguments.get("start") or 0),
                count=_whole(arguments.get("count") or 500),
            )
        else:
            variables = await self._request("variables", scope=reference.scope, call=reference.call)
        return reference, variables

    async def _variables(self, arguments: Arguments) -> Any:
        reference, variables = await self._parts(arguments.get("variablesReference"), arguments)
        return {"variables": [self._variable(one, reference) for one in variables]}

    def _variable(self, one: Mapping[str, Any], reference: _Reference) -> dict[str, Any]:
        is_list = reference.scope == "lists"
        inner = (
            _Reference(reference.call, one["path"])
            if is_list
            else _Reference(reference.call, path=one["path"])
        )
        shown = {
            "name": one["name"],
            "value": one["value"],
            "type": one["type"],
            "evaluateName": one["path"],
            "variablesReference": self._refer(inner) if one["parts"] else 0,
        }
        if one.get("indexed") and one["count"] > 100:
            shown["indexedVariables"] = one["count"]
        return shown

    async def _evaluate(self, arguments: Arguments) -> Any:
        text = arguments.get("expression")
        if not isinstance(text, str):
            raise _Refused("expression: a text")
        call = max(_whole(arguments.get("frameId") or 1) - 1, 0)
        target, assigns, value = text.partition(":=")
        if assigns and arguments.get("context") == "repl":
            one = await self._request("set", target=target.strip(), value=value.strip(), call=call)
        else:
            one = await self._request("evaluate", expression=text, call=call)
        shown = self._variable(one, _Reference(call))
        return {
            "result": shown["value"],
            "type": shown["type"],
            "variablesReference": shown["variablesReference"],
        }

    async def _set_variable(self, arguments: Arguments) -> Any:
        name, value = arguments.get("name"), arguments.get("value")
        if not isinstance(name, str) or not isinstance(value, str):
            raise _Refused("name and value: texts")
        reference, variables = await self._parts(arguments.get("variablesReference"), {})
        for one in variables:
            if one["name"] == name:
                return self._changed(
                    await self._request("set", target=one["path"], value=value, call=reference.call)
                )
        raise _Refused(f"no variable is named {name!r} here")

    async def _set_expression(self, arguments: Arguments) -> Any:
        target, value = arguments.get("expression"), arguments.get("value")
        if not isinstance(target, str) or not isinstance(value, str):
            raise _Refused("expression and value: texts")
        call = max(_whole(arguments.get("frameId") or 1) - 1, 0)
        return self._changed(await self._request("set", target=target, value=value, call=call))

    def _changed(self, one: Mapping[str, Any]) -> dict[str, Any]:
        return {"value": one["value"], "type": one["type"], "variablesReference": 0}

    # going on --------------------------------------------------------------------------------

    async def _go(self, do: str, **fields: Any) -> Any:
        self._is_stopped = False
        state = await self._request(do, **fields)

        async def notice() -> None:
            self._notice(state)

        self._after.append(notice)
        return {"allThreadsContinued": True}

    async def _pause(self, arguments: Arguments) -> None:
        await self._request("pause")


class _Logs(logging.Handler):
    """Hands on log records of warnings and above, as text."""

    def __init__(self, take: Callable[[str], None]) -> None:
        super().__init__(logging.WARNING)
        self._take = take

    def emit(self, record: logging.LogRecord) -> None:
        self._take(f"{record.levelname.lower()}: {record.getMessage()}")


def _real(path: str) -> str:
    """Return the path without links, as the station names its files."""
    try:
        return str(Path(path).resolve())
    except (OSError, ValueError, RuntimeError):
        return path


def _whole(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 1 << 31:
        raise _Refused(f"a number from 0, got {value!r:.80}")
    return value
