"""The root of the command tree; it reports errors of the command line like all others."""

import sys
from collections.abc import Sequence
from typing import Any, cast

import typer
from typer.core import TyperGroup

from achse.cli.failure import errors_in_json, in_json, print_failure, wants_json

PANELS = {
    "Start": ("new", "run", "demo", "wait", "stop", "fleet", "web", "fmu"),
    "ADS": ("ads", "router"),
    "Axes": ("axis", "table", "camshaft"),
    "Programs": ("channel", "gcode"),
    "Fieldbus": ("bus", "drive"),
    "PLC": ("plc", "symbols", "format", "lsp", "mcp"),
    "Record": ("scope", "monitor", "replay", "diff"),
    "Test": ("check", "explain", "test", "mutate", "fault", "sweep", "swarm"),
    "Install": ("docs", "warmup", "certificate", "hash-password"),
}
"""Panels of `achse --help`, by purpose, with their commands; each is a room of `achse.cli`."""

_MOST_OPTIONS = 6

_ELSEWHERE = {
    "init": "new",
    "create": "new",
    "start": "run",
    "serve": "run",
    "read": "ads read",
    "write": "ads write",
    "symbol": "symbols",
    "info": "ads state",
    "watch": "ads read",
    "record": "monitor",
    "move": "axis move",
    "jog": "axis jog",
    "validate": "check",
    "breakpoint": "plc break",
    "debug": "plc debug",
    "password": "hash-password",
}
"""Commands of other tools, and ours for them."""

_INSIDE = {
    **dict.fromkeys(("list", "ls", "status", "state", "print"), ("show", "state", "objects")),
    **dict.fromkeys(("get", "set"), ("show", "sdo")),
    "show": ("state", "list", "objects"),
    "read": ("show", "sdo"),
    "write": ("set", "sdo"),
    "watch": ("show", "read", "state"),
    "info": ("state",),
    "statistics": ("state",),
    "gear": ("couple",),
    "reverse": ("excite",),
    "sine": ("excite",),
    "torque": ("excite",),
    "export": ("show",),
    "open": ("show",),
    "plot": ("check",),
    "esi": ("export",),
    "sii": ("export",),
    "where": ("show",),
    "clear": ("break",),
    "pause": ("step",),
    "load": ("start",),
}
"""Words of other tools inside a group, and ours for them: the first that the group has."""

_MOVED = {
    "ads router": "ads stats",
    "ads symbols": "symbols",
    "bus fault": "fault --bus",
    "channel offsets": "channel show --offsets",
    "channel tools": "channel show --tools",
    "drive fault": "fault --served",
    "drive get": "bus sdo --served",
    "drive sdo": "bus sdo --served",
    "drive set": "bus sdo --served",
    "drive state": "bus state --served",
    "drive watch": "bus state --served --watch",
    "fault kinds": "fault list --kinds",
    "fleet station": "fleet up --station",
    "gcode check": "gcode FILE",
    "gcode plot": "gcode FILE --plot",
    "gcode time": "gcode FILE --time",
    "certificate show": "certificate HOST",
    "new project": "new NAME",
    "new station": "new NAME --no-tests",
    "new test": "new tests/test_NAME.py",
    "plc end": "plc continue --end",
    "router status": "ads stats",
}
"""Commands of earlier versions whose words are not those of ours, and what they are now."""

_EXPECTED = {
    "a valid integer": "a whole number",
    "a valid number": "a number",
    "a valid boolean": "true or false",
    "less than or equal to": "at most",
    "greater than or equal to": "at least",
    "greater than": "more than",
}
"""Words of the parser about values, and ours."""

_UsageError = cast(type[Exception], typer.BadParameter.__base__)
_CommandError = cast(type[Exception], _UsageError.__base__)
"""Base of the exceptions from the command line's parser; Typer does not export it."""


class Front(TyperGroup):
    """The commands of achse; with `--json` on the command line errors are objects."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of the commands in the order of the panels."""
        names = super().list_commands(ctx)
        return [name for panel in PANELS.values() for name in panel if name in names]

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        windows_expand_args: bool = True,
        **extra: Any,
    ) -> Any:
        """Run a command line; standalone it ends the process."""
        words = sys.argv[1:] if args is None else list(args)
        with errors_in_json(wants_json(words)):
            try:
                code = super().main(
                    args, prog_name, complete_var, False, windows_expand_args, **extra
                )
            except _CommandError as fault:
                if not standalone_mode:
                    raise
                code = _report(fault)
            except typer.Abort:
                if not standalone_mode:
                    raise
                print_failure("aborted", name="ABORTED")
                code = 1
        if not standalone_mode:
            return code
        sys.exit(code)


def _report(fault: Any) -> int:
    """Report an error of the command line; return the exit code."""
    fault.message = _in_our_words(fault.message or "", fault.__cause__)
    unknown = fault.message.removeprefix("No such command '").partition("'")[0]
    moved = _moved(unknown, fault)
    if fault.message.startswith("Got unexpected extra argument"):
        fault.message += "." if moved else _options(fault)
    # what is meant goes before what is spelled alike
    if near := moved or _command_for(unknown, fault):
        fault.message = f"{fault.message.partition(' Did you mean')[0]} Did you mean '{near}'?"
    if in_json():
        print_failure(
            fault.format_message(), name="USAGE" if isinstance(fault, _UsageError) else "FAILED"
        )
    else:
        from typer.rich_utils import rich_format_error

        rich_format_error(fault)
    return int(fault.exit_code)


def _in_our_words(message: str, cause: Any) -> str:
    """Return what is expected of a value and what came, without the words of the parser."""
    message = message.removeprefix("Value error, ")
    head, separator, expected = message.partition("Input should be ")
    if not separator:
        return message
    expected = expected.partition(", unable to parse")[0]
    theirs = next((words for words in _EXPECTED if expected.startswith(words)), "")
    details = cause.errors() if hasattr(cause, "errors") else ()
    value = f", got {str(details[0]['input'])!r:.80}" if details else ""
    return f"{head}expected {_EXPECTED.get(theirs, theirs)}{expected[len(theirs) :]}{value}"


def _moved(word: str, fault: Any) -> str | None:
    """Return what a command of an earlier version is now; its last word may be an argument."""
    context = getattr(fault, "ctx", None)
    if context is None:
        return None
    group = context.command_path.partition(" ")[2]
    words = (word, *(str(value) for value in context.params.values()))
    return next((_MOVED[typed] for one in words if (typed := f"{group} {one}") in _MOVED), None)


def _command_for(word: str, fault: Any) -> str | None:
    """Return our command for a word that another tool uses, in the group where it was typed."""
    context = getattr(fault, "ctx", None)
    group = None if context is None else context.command
    if group is None or isinstance(group, Front):
        return _ELSEWHERE.get(word)
    return next((name for name in _INSIDE.get(word, ()) if name in group.commands), None)


def _options(fault: Any) -> str:
    """Return `; options say what a value is: --to, --by` with the options of the command."""
    context = getattr(fault, "ctx", None)
    known = [] if context is None else context.command.params
    names = [
        max(one.opts, key=len)
        for one in known
        if one.param_type_name == "option" and not getattr(one, "is_flag", False) and not one.hidden
    ]
    names = [name for name in names if name.startswith("--")][:_MOST_OPTIONS]
    return f"; options say what a value is: {', '.join(names)}" if names else ""
