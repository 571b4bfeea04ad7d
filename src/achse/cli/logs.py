"""Logs of a station on stderr: lines for people, or a JSON document a line for programs."""

import json
import logging
import sys
import time
from enum import Enum


class LogFormat(Enum):
    """Format of a log record."""

    TEXT = "text"
    JSON = "json"


class LogLevel(Enum):
    """Lowest level of the records written."""

    DEBUG = "debug"
    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


_WHO = ("client", "peer")
"""Fields of records about a client beside the message: its AMS address; its host and port."""


class _Json(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        seconds, fraction = divmod(record.created, 1)
        document = {
            "time": time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(seconds))
            + f".{int(fraction * 1e6):06}Z",
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
        }
        document |= {name: text for name in _WHO if (text := getattr(record, name, ""))}
        if record.exc_info:
            document["traceback"] = self.formatException(record.exc_info)
        return json.dumps(document, ensure_ascii=False)


def set_up_logs(form: LogFormat, level: LogLevel) -> None:
    """Write the records of `achse` and above to stderr, in a thread of its own."""
    from achse.cli.log_writer import LogWriter

    handler = LogWriter(sys.stderr)
    if form is LogFormat.JSON:
        handler.setFormatter(_Json())
    else:
        handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))
    handler.setLevel(level.name)  # a page may have lines that are not written here
    logging.basicConfig(handlers=[handler], level=level.name, force=True)
