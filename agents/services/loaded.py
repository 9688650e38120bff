"""Applications that a container starts by the name of their program, as a kind of agents.

    {"do": "start", "name": "patrol@apps", "kind": "agents.services.loaded:_LoadedApplication",
     "properties": {"program": "patrol", "arguments": {"robot": "happy"}}}

Only names are sent on the bus, never programs: a program is in a folder that the container was given with `--apps`, or
is part of Acromovi. So only a person who may write into that folder determines what runs on that machine.
"""

import asyncio
import hashlib
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

from agents.client.application import Application
from agents.client.program import PACKAGE, ProgramNotValid, RunningApplication
from agents.platform import AgentError, AgentName

KIND = f"{__name__}:_LoadedApplication"


class _NotLoaded(AgentError):
    """An application cannot be loaded; the message says why in one sentence."""


class _LoadedApplication(Application):
    """An application whose program is loaded in its container.

    Properties: `program`, its name; `arguments`, for its `main`; `sha256`, its digest, if only this text may run.
    """

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        """Construct it without its program.

        Raises:
            _NotLoaded: The properties name none.
        """
        given = dict(properties or {})
        program, arguments = given.get("program"), given.get("arguments", {})
        if not isinstance(program, str) or not isinstance(arguments, dict):
            raise _NotLoaded('the properties of an application are like {"program": "patrol", "arguments": {}}')
        super().__init__(RunningApplication(program, ModuleType(program)), name, arguments)
        self.properties = given

    async def load(self) -> RunningApplication:
        """Return the program, after checking its arguments.

        Raises:
            _NotLoaded: There is none of this name here, it cannot be loaded, or does not take these arguments.
        """
        try:
            return await asyncio.to_thread(self._load)
        except ProgramNotValid as err:
            raise _NotLoaded(str(err)) from err

    def _load(self) -> RunningApplication:
        name, folders = str(self.properties["program"]), self.home.folders
        check(name, folders, self.properties.get("sha256", ""))
        try:
            program = RunningApplication.find(name, folders)
        except SystemExit as err:
            raise ProgramNotValid(f"{name} calls sys.exit as it is loaded; do that in its main") from err
        program.check(self._arguments)
        return program


def check(name: str, folders: Sequence[Path], sha256: object) -> None:
    """Check that an application is the requested program, without executing it.

    Args:
        name: The application.
        folders: Where to look first.
        sha256: The digest of the program in hexadecimal; empty for any program.
    Raises:
        ProgramNotValid: There is none of this name, it is a path, or the program has another digest.
    """
    file = _locate(name, folders)
    if sha256 and digest(file) != sha256:
        raise ProgramNotValid(f"{file} there is another program than yours; copy yours there, and load it again")


def _locate(name: str, folders: Sequence[Path]) -> Path:
    if not name.isidentifier():
        raise ProgramNotValid(f"{name!r} names no application; give the name of its file without folder and .py")
    for folder in folders:
        if (file := folder / f"{name}.py").is_file():
            return file
    spec = find_spec(f"{PACKAGE}.{name}")
    if spec is not None and spec.origin is not None:
        return Path(spec.origin)
    raise ProgramNotValid(f"there is no application {name!r} there; {_advice(name, folders)}")


def digest(file: Path) -> str:
    """Return the SHA-256 of a program, in hexadecimal."""
    return hashlib.sha256(file.read_bytes()).hexdigest()


def _advice(name: str, folders: Sequence[Path]) -> str:
    if not folders:
        return "it takes none but those that Acromovi brings, unless it is started with --apps FOLDER"
    return f"copy {name}.py into {' or '.join(map(str, folders))} on that machine"
