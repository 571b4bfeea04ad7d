"""The scene: a JSON file that describes the machine for its picture."""

import asyncio
import json
from pathlib import Path
from typing import Any

from achse.web.arguments import Arguments
from achse.web.messages import CallError

_LARGEST = 1 << 20


class SceneHandlers:
    """Gives the scene of a station; `file` None: it has none."""

    def __init__(self, file: Path | None) -> None:
        self._file = file

    async def there(self) -> bool:
        """Return True if a scene file was named."""
        return self._file is not None

    async def scene(self, arguments: Arguments) -> Any:
        """Call `scene`: the file's JSON as it is now; null without one."""
        if self._file is None:
            return None
        try:
            text = await asyncio.to_thread(self._file.read_bytes)
        except OSError as failure:
            raise CallError(f"scene: {self._file.name}: {failure.strerror}") from None
        if len(text) > _LARGEST:
            raise CallError(f"scene: {self._file.name}: expected up to {_LARGEST} bytes")
        try:
            return json.loads(text)
        except (ValueError, RecursionError):
            raise CallError(f"scene: {self._file.name}: expected a JSON document") from None
