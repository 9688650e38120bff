"""Results of a long run, a line of JSON for each as it ends, so that after an interruption only the rest is played."""

import json
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any, ClassVar, Generic, Protocol, TypeVar

import configs
from bus.bus import Closeable
from configs import ConfigError


class _Dataclass(Protocol):
    __dataclass_fields__: ClassVar[dict[str, Any]]


T = TypeVar("T", bound=_Dataclass)


class ResultsFile(Closeable, Generic[T]):
    """A file of frozen dataclasses of one kind. earlier: those that it had when it was opened."""

    def __init__(self, path: Path, kind: type[T], *, resume: bool) -> None:
        """Open the file, in a folder that is made if it is missing.

        Args:
            path: Of the file.
            kind: Class of the results; its fields are what `configs.build` can build.
            resume: Whether to keep what is in the file, but for a last line that was not written whole; otherwise the
                file is emptied.
        Raises:
            ConfigError: The file cannot be written, or has a line that is no such result; says which.
        """
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            text = path.read_bytes() if resume and path.exists() else b""
            whole = text[: text.rfind(b"\n") + 1]
            self.earlier = [_read(kind, line, f"{path}, line {at}") for at, line in enumerate(whole.splitlines(), 1)]
            self._file = path.open("ab")
            self._file.truncate(len(whole))
        except OSError as err:
            raise ConfigError(f"{path} cannot be written: {err.strerror}; choose another folder") from err

    def add(self, results: Iterable[T]) -> None:
        """Write results, so that they are kept whatever happens to this process."""
        self._file.writelines(json.dumps(asdict(result)).encode() + b"\n" for result in results)
        self._file.flush()

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def _read(kind: type[T], line: bytes, where: str) -> T:
    try:
        row = json.loads(line)
    except ValueError as err:
        raise ConfigError(f"{where}: not JSON ({err}); begin anew, without --resume") from err
    return configs.build(kind, row, where)
