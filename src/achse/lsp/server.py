"""The server: requests of a client, answered from its editor state.

Changes are checked when the client pauses for a moment, or when it asks for something.
"""

import asyncio
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO

from cattrs import transform_error
from lsprotocol import types
from pygls.exceptions import JsonRpcException, JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer
from pygls.protocol import LanguageServerProtocol, json_rpc
from pygls.protocol.json_rpc import JsonRPCNotification

from achse.lsp.actions import code_actions
from achse.lsp.completion import complete, signature_help
from achse.lsp.diagnostics import Published
from achse.lsp.documents import Encoding
from achse.lsp.editor import Editor
from achse.lsp.formatting import format_document, format_range
from achse.lsp.hover import hover
from achse.lsp.navigation import (
    call_items,
    definition,
    document_symbols,
    highlights,
    incoming_calls,
    outgoing_calls,
    references,
    type_definition,
    workspace_symbols,
)
from achse.lsp.projects import Projects
from achse.lsp.rename import prepare_rename, rename
from achse.lsp.tokens import LEGEND, semantic_tokens
from achse.st.files.forms import FORMS

_PAUSE_S = 0.03
"""Time without a change after which findings are sent."""
_LINT_PAUSE_S = 0.3
"""Further time after which those of the linter are sent, which looks at the whole project."""

_LONGEST_MESSAGE = 1 << 28
_LONGEST_LINE = 1 << 13
_MOST_DIGITS = 30

_NOT_INITIALIZED = -32002
_INVALID_REQUEST = -32600

_WATCHED = (
    f"**/*.{{{','.join(form.suffix[1:] for form in FORMS)}}}",
    "**/achse.toml",
)


class MessageTooLong(ValueError):
    """The client announced a message of a length that none has."""


class BoundedInput:
    """The stream of a client's messages. What follows a wrong length cannot be read."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream

    def readline(self) -> bytes:
        """Return a line of a header, or what is too long for one piece by piece. Raises
        `MessageTooLong`."""
        line = self._stream.readline(_LONGEST_LINE)
        name, colon, value = line.partition(b":")
        if not colon or name.strip().lower() != b"content-length" or not value.strip().isdigit():
            return line
        digits = value.strip()  # names of fields are without case, which pygls does not know
        if len(digits) > _MOST_DIGITS:
            raise MessageTooLong(
                f"Content-Length: expected up to {_LONGEST_MESSAGE}, got {len(digits)} digits"
            )
        return b"Content-Length: %s\r\n" % digits

    def read(self, length: int) -> bytes:
        """Return a message. Raises `MessageTooLong`."""
        if length > _LONGEST_MESSAGE:
            raise MessageTooLong(
                f"Content-Length: expected up to {_LONGEST_MESSAGE}, got {str(length)[:30]}"
            )
        return self._stream.read(length)


class _Protocol(LanguageServerProtocol):
    """The protocol, with an answer to requests whose parameters or time is wrong."""

    def handle_message(self, message: Any) -> None:
        method = getattr(message, "method", None)
        if isinstance(method, str) and hasattr(message, "id"):
            error = self._refusal(method)
            if error is not None:
                self._send_response(message.id, error=error)
                return
        super().handle_message(message)

    def _refusal(self, method: str) -> types.ResponseError | None:
        """Return the error of a request that comes too early, twice or too late."""
        if self._shutdown:
            return types.ResponseError(_INVALID_REQUEST, f"{method[:100]}: after shutdown")
        is_initialized = getattr(self, "server_capabilities", None) is not None
        if method == types.INITIALIZE and is_initialized:
            return types.ResponseError(_INVALID_REQUEST, "initialize: expected once")
        if method not in (types.INITIALIZE, types.SHUTDOWN) and not is_initialized:
            return types.ResponseError(
                _NOT_INITIALIZED, f"expected initialize first, got {method[:100]}"
            )
        return None

    def structure_message(self, data: dict[str, Any]) -> Any:
        try:
            return super().structure_message(data)
        except JsonRpcException as fault:
            cause = fault.__cause__
            reason = "; ".join(transform_error(cause)) if cause is not None else fault.message
            method = str(data.get("method", ""))[:100]
            if "id" in data and method:
                error = types.ResponseError(fault.code, f"{method}: {reason[:500]}")
                self._send_response(data["id"], error=error)
            return JsonRPCNotification(method="$/refused", params=None, jsonrpc=self.VERSION)


class _WithoutLateCancels(logging.Filter):
    """Leave out the cancels that come behind their answer: each pause in typing has some."""

    def filter(self, record: logging.LogRecord) -> bool:
        return not str(record.msg).startswith("Cancel notification for unknown")


_LATE_CANCELS = _WithoutLateCancels()


class LspServer(LanguageServer):
    """A language server with the state of its client."""

    def __init__(self, version: str = "") -> None:
        super().__init__(
            "achse",
            version,
            text_document_sync_kind=types.TextDocumentSyncKind.Incremental,
            protocol_cls=_Protocol,
        )
        self.editor = Editor()
        self.published = Published(self.editor)
        logging.getLogger(json_rpc.__name__).addFilter(_LATE_CANCELS)
        self._timer: asyncio.TimerHandle | None = None
        self._reported: set[str] = set()
        """Faults in files of options that the user knows."""

    def check_soon(self) -> None:
        """Check and send findings once the client pauses."""
        if self._timer is not None:
            self._timer.cancel()
        self._timer = asyncio.get_running_loop().call_later(_PAUSE_S, self.check_now)

    def check_now(self) -> None:
        """Check what changed, and send the findings that are new."""
        self._timer = None
        try:
            self.editor.update()
            for params in self.published.changes():
                self.text_document_publish_diagnostics(params)
            self._report_lint_options()
            if any(not workspace.is_linted for workspace in self.editor.projects):
                loop = asyncio.get_running_loop()
                self._timer = loop.call_later(_LINT_PAUSE_S, self.lint_now)
        except Exception as fault:  # one document must not end the server for all
            self.window_log_message(
                types.LogMessageParams(types.MessageType.Error, f"check failed: {fault!r}")
            )

    def _report_lint_options(self) -> None:
        failures = {one.lint_failure for one in self.editor.projects if one.lint_failure}
        for failure in sorted(failures - self._reported):
            self.window_show_message(types.ShowMessageParams(types.MessageType.Warning, failure))
        self._reported = failures

    def lint_now(self) -> None:
        """Run the linter where it is on, and send the findings that are new."""
        self.editor.projects.lint()
        self.check_now()

    def report_server_error(self, error: Exception, source: Any) -> None:
        """Log what went wrong: the request has its answer, and no window need open."""
        self.window_log_message(types.LogMessageParams(types.MessageType.Warning, str(error)))


_Handler = Callable[[Editor, Any], Any]

_REQUESTS: tuple[tuple[str, _Handler, Any], ...] = (
    (types.TEXT_DOCUMENT_HOVER, hover, None),
    (types.TEXT_DOCUMENT_DEFINITION, definition, None),
    (types.TEXT_DOCUMENT_TYPE_DEFINITION, type_definition, None),
    (types.TEXT_DOCUMENT_REFERENCES, references, None),
    (types.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT, highlights, None),
    (types.TEXT_DOCUMENT_DOCUMENT_SYMBOL, document_symbols, None),
    (types.WORKSPACE_SYMBOL, workspace_symbols, None),
    (
        types.TEXT_DOCUMENT_COMPLETION,
        complete,
        types.CompletionOptions(trigger_characters=[".", "^", "#"]),
    ),
    (
        types.TEXT_DOCUMENT_SIGNATURE_HELP,
        signature_help,
        types.SignatureHelpOptions(trigger_characters=["(", ",", "="]),
    ),
    (types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, semantic_tokens, LEGEND),
    (types.TEXT_DOCUMENT_PREPARE_CALL_HIERARCHY, call_items, None),
    (types.CALL_HIERARCHY_INCOMING_CALLS, incoming_calls, None),
    (types.CALL_HIERARCHY_OUTGOING_CALLS, outgoing_calls, None),
    (
        types.TEXT_DOCUMENT_CODE_ACTION,
        code_actions,
        types.CodeActionOptions(code_action_kinds=[types.CodeActionKind.QuickFix]),
    ),
    (types.TEXT_DOCUMENT_FORMATTING, format_document, None),
    (types.TEXT_DOCUMENT_RANGE_FORMATTING, format_range, None),
    (types.TEXT_DOCUMENT_PREPARE_RENAME, prepare_rename, None),
    (types.TEXT_DOCUMENT_RENAME, rename, types.RenameOptions(prepare_provider=True)),
)


def new_server(version: str = "") -> LspServer:
    """Return a server for one client, which says that it has this version."""
    server = LspServer(version)
    _add_lifecycle(server)
    _add_documents(server)
    for method, answer, options in _REQUESTS:
        _add_request(server, method, answer, options)
    return server


def _add_request(server: LspServer, method: str, answer: _Handler, options: Any) -> None:
    def handle(params: Any) -> Any:
        return answer(server.editor, params)

    server.feature(method, options)(handle)


def _add_lifecycle(server: LspServer) -> None:
    @server.feature(types.INITIALIZE)
    def initialize(params: types.InitializeParams) -> None:
        editor = server.editor
        editor.encoding = Encoding(server.workspace.position_encoding or "utf-16")
        options = params.initialization_options
        if options is not None and not isinstance(options, dict):
            raise JsonRpcInvalidParams("initializationOptions: expected an object")
        folders = [folder.uri for folder in params.workspace_folders or ()]
        if not folders and params.root_uri:
            folders = [params.root_uri]
        editor.projects = Projects(
            [editor.file_of(uri) for uri in folders if uri.startswith("file:")],
            [Path(item) for item in _texts(options, "libraries")],
            _texts(options, "defines"),
        )

    @server.feature(types.INITIALIZED)
    def initialized(params: types.InitializedParams) -> None:
        _watch_files(server)
        server.editor.projects.load()
        server.check_soon()


def _watch_files(server: LspServer) -> None:
    """Let the client report files that change on disk, if it can."""
    workspace = server.client_capabilities.workspace
    watching = None if workspace is None else workspace.did_change_watched_files
    if watching is None or not watching.dynamic_registration:
        return
    watchers = [types.FileSystemWatcher(pattern) for pattern in _WATCHED]
    server.client_register_capability(
        types.RegistrationParams(
            [
                types.Registration(
                    "achse-files",
                    types.WORKSPACE_DID_CHANGE_WATCHED_FILES,
                    types.DidChangeWatchedFilesRegistrationOptions(watchers),
                )
            ]
        )
    )


def _texts(options: Any, key: str) -> list[str]:
    value = (options or {}).get(key, [])
    if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
        raise JsonRpcInvalidParams(f"initializationOptions.{key}: expected a list of texts")
    return value


def _add_documents(server: LspServer) -> None:
    @server.feature(types.TEXT_DOCUMENT_DID_OPEN)
    def opened(params: types.DidOpenTextDocumentParams) -> None:
        document = params.text_document
        server.editor.open(document.uri, document.text, document.version)
        server.check_soon()

    @server.feature(types.TEXT_DOCUMENT_DID_CHANGE)
    def changed(params: types.DidChangeTextDocumentParams) -> None:
        document = params.text_document
        wrong = server.editor.change(document.uri, document.version, list(params.content_changes))
        if wrong:
            server.window_log_message(types.LogMessageParams(types.MessageType.Warning, wrong))
        server.check_soon()

    @server.feature(types.TEXT_DOCUMENT_DID_CLOSE)
    def closed(params: types.DidCloseTextDocumentParams) -> None:
        server.editor.close(params.text_document.uri)
        server.check_soon()

    @server.feature(types.TEXT_DOCUMENT_DID_SAVE)
    def saved(params: types.DidSaveTextDocumentParams) -> None:
        server.check_soon()

    @server.feature(types.WORKSPACE_DID_CHANGE_WATCHED_FILES)
    def watched(params: types.DidChangeWatchedFilesParams) -> None:
        uris = (change.uri for change in params.changes)
        files = [server.editor.file_of(uri) for uri in uris if uri.startswith("file:")]
        server.editor.projects.reread(files)
        server.check_soon()
