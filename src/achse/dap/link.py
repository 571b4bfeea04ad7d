"""Asking a station's debugging service, as any client does."""

import json
from typing import Any

from achse.client import Client
from achse.devices.debugging import DEBUG

_LONGEST = 1 << 22
"""Bytes of an answer."""


class DebugRefused(Exception):
    """The station says why not."""


class DebugLink:
    """One PLC of a station, by AMS port; 0 is the first. `client` asks the station's own port."""

    def __init__(self, client: Client, plc: int = 0) -> None:
        self._client = client
        self._plc = plc

    async def request(self, do: str, /, **fields: Any) -> Any:
        """Return the service's answer. Raises `DebugRefused`, and AdsError for the connection."""
        request = json.dumps({"do": do, **fields}).encode()
        answer = await self._client.read_write_raw(DEBUG, self._plc, _LONGEST, request)
        reply = json.loads(answer)
        if isinstance(reply, dict) and "error" in reply:
            raise DebugRefused(str(reply["error"]))
        return reply

    async def state(self) -> dict[str, Any]:
        """Return the state of the PLC."""
        state: dict[str, Any] = await self.request("state")
        return state
