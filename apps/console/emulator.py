"""Requests to the control socket of an emulator, without blocking the event loop."""

import asyncio
import json
from typing import Any

_ANSWER = 2.0  # s
_LONGEST = 1 << 22  # bytes of an answer


class EmulatorRefused(Exception):
    """The emulator refused a request, or does not answer; the message says why."""


class EmulatorControl:
    """The emulator behind a control socket. path: of the socket."""

    def __init__(self, path: str) -> None:
        self.path = path

    async def ask(self, do: str, **arguments: Any) -> dict[str, Any]:
        """Send one request, and return the answer.

        Raises:
            EmulatorRefused: It was not carried out.
        """
        try:
            async with asyncio.timeout(_ANSWER):
                reader, writer = await asyncio.open_unix_connection(self.path, limit=_LONGEST)
                try:
                    writer.write(json.dumps({"do": do, **arguments}).encode() + b"\n")
                    answer = json.loads(await reader.readline())
                finally:
                    writer.close()
        except TimeoutError:
            raise EmulatorRefused(f"the emulator has not answered within {_ANSWER:g} s") from None
        except (OSError, ValueError) as err:
            raise EmulatorRefused(f"the emulator does not answer any more: {err}") from err
        if not isinstance(answer, dict) or not answer.get("ok"):
            raise EmulatorRefused(str(answer.get("error")) if isinstance(answer, dict) else "its answer is damaged")
        return answer
