"""Kinds of agents by name, `module:Class`: the agents that a container can be told to start.

Only classes in the packages `agents` and `apps`, or in a folder of applications that the container was given, are
permitted, so that no program can run arbitrary code in a container.
"""

import importlib
import inspect
import pkgutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import module_from_spec
from pathlib import Path
from types import ModuleType
from typing import Any

from agents.platform.agent import Agent
from agents.platform.errors import AgentError, in_words
from agents.platform.names import AgentName
from configs.suggestion import meant

PACKAGES = ("agents", "apps")


class UnknownKind(AgentError, LookupError):
    """There is no kind of agents with this name, or it is not in the permitted places."""


class Kinds:
    """The places where kinds are searched.

    folders: of applications; `follow.py` in one of them is the module `follow`.
    """

    def __init__(self, folders: Sequence[Path] = ()) -> None:
        self.folders = tuple(folder.resolve() for folder in folders)

    def find(self, kind: str) -> type[Agent]:
        """Load the module of a kind, and return the class.

        A module of a folder is loaded again when its file has changed, so that an application can be corrected and
        restarted.

        Raises:
            UnknownKind: There is none; the message gives the nearest name.
        """
        module_name, colon, class_name = kind.partition(":")
        if not (module_name and colon and class_name):
            raise UnknownKind(f"{kind!r} names no kind of agents; write module:Class, such as agents.platform:Agent")
        module = self._load(module_name)
        found = getattr(module, class_name, None)
        if not (isinstance(found, type) and issubclass(found, Agent)):
            known = [name for name, value in vars(module).items() if _is_kind(value, module)]
            raise UnknownKind(f"there is no agent {class_name!r} in {module_name}{_advice(class_name, known)}")
        if inspect.isabstract(found):
            raise UnknownKind(f"{kind} is a base for kinds of agents and none itself")
        return found

    def make(self, kind: str, name: AgentName, properties: Mapping[str, Any]) -> Agent:
        """Return a new agent of a kind, not started.

        Raises:
            UnknownKind: There is no such kind, or its constructor does not take a name and properties.
        """
        found = self.find(kind)
        try:
            return found(name, properties)
        except Exception as err:
            raise UnknownKind(f"{kind} cannot be made: {in_words(err)}") from err

    def modules(self) -> list[str]:
        """Return all modules that may have kinds, in alphabetical order; only the packages are loaded."""
        applications = (module.name for module in pkgutil.iter_modules([str(folder) for folder in self.folders]))
        return sorted({*applications, *(name for package in PACKAGES for name in _inside(package))})

    def _load(self, name: str) -> ModuleType:
        in_package = name.partition(".")[0] in PACKAGES
        spec = None if in_package else PathFinder.find_spec(name, [str(folder) for folder in self.folders])
        if not in_package and spec is None:
            where = " or in ".join(("the packages agents and apps", *map(str, self.folders)))
            where += "" if self.folders else ", and no folder was given with --apps"
            raise UnknownKind(f"there is no module {name!r} in {where}{_advice(name, self.modules())}")
        try:
            return importlib.import_module(name) if spec is None else self._application(spec)
        except ModuleNotFoundError as err:
            if err.name is None or not f"{name}.".startswith(f"{err.name}."):
                raise UnknownKind(f"the module {name} cannot be loaded: {err}") from err
            raise UnknownKind(f"there is no module {name!r}{_advice(name, self.modules())}") from err
        except UnknownKind:
            raise
        except Exception as err:  # an error in an application must not end the container
            raise UnknownKind(f"the module {name} cannot be loaded: {in_words(err)}") from err

    def _application(self, spec: ModuleSpec) -> ModuleType:
        """Return a module of a folder; it is executed at first and whenever its file has changed."""
        if spec.origin is None or spec.loader is None:
            raise UnknownKind(f"{spec.name!r} is a folder without __init__.py, and so no application")
        now = (spec.origin, Path(spec.origin).stat().st_mtime_ns)
        there = sys.modules.get(spec.name)
        if getattr(there, _STATE_OF_FILE, None) == now:
            return sys.modules[spec.name]
        if spec.name in sys.stdlib_module_names or (there is not None and not hasattr(there, _STATE_OF_FILE)):
            raise UnknownKind(f"{spec.name!r} is the name of another module of Python; give the file another name")
        sys.path.extend(str(folder) for folder in self.folders if str(folder) not in sys.path)  # last: it hides nothing
        module = module_from_spec(spec)
        sys.modules[spec.name] = module  # where what the module defines is looked for by its name
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[spec.name]
            raise
        setattr(module, _STATE_OF_FILE, now)
        return module


_STATE_OF_FILE = "_loaded_from"  # of a module of an application: its file, and when that was changed


def _inside(package: str) -> Iterator[str]:
    """Return the names of all modules of a package."""
    for module in pkgutil.walk_packages(importlib.import_module(package).__path__, f"{package}."):
        yield module.name


def _is_kind(value: object, module: ModuleType) -> bool:
    return isinstance(value, type) and issubclass(value, Agent) and value.__module__ == module.__name__


def _advice(name: str, known: Sequence[str]) -> str:
    near = meant(name, known)
    return f"; did you mean {near}?" if near else ""
