"""An application before it runs: a file, or a module of the package `apps`, with a function `main(team)`.

The module of an application with several modules is `application` in its folder.

    from agents import Team, request

    def main(team: Team, speed: float = 0.2):
        ...

    @request("laps")
    def laps():
        return 3

As an agent it offers the services in `SERVICES = ("patrol",)`, and is restarted after a failure with `RESTART = True`.
"""

import importlib
import importlib.util
import inspect
import pkgutil
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, Self

from agents.client.complaints import complaint
from agents.client.errors import RobotError
from agents.platform.conversations.handler import Handler, NotUnderstood
from agents.platform.errors import in_words
from configs.suggestion import meant

PACKAGE = "apps"


class ProgramNotValid(RobotError):
    """There is no such application, it cannot be loaded, or it does not take these arguments."""


class _ProgramFailed(RobotError):
    """An application raised an error of its own; the message names it and the line."""


@dataclass(frozen=True, slots=True)
class RunningApplication:
    """An application that has been loaded.

    name: for messages and for its agent.
    """

    name: str
    module: ModuleType

    @classmethod
    def find(cls, name: str, folders: Sequence[Path] = ()) -> Self:
        """Load an application.

        Args:
            name: A file that ends in `.py`, or a name: of a file in one of the folders, or of a module or a folder in
                `apps`.
            folders: Where to look first for a name.
        Raises:
            ProgramNotValid: There is none, or it cannot be loaded.
        """
        places = [Path(name)] if name.endswith(".py") else [folder / f"{name}.py" for folder in folders]
        file = next((place for place in places if place.is_file()), None)
        if file is None and (name.endswith(".py") or name not in _names_in_package()):
            raise ProgramNotValid(f"there is no application {name!r}{_advice(name, folders)}")
        module = _load_file(file) if file is not None else _load_module(_module_of(name))
        main = getattr(module, "main", None)
        if not callable(main) or not inspect.signature(main).parameters:
            raise ProgramNotValid(f"{file or name} has no function main(team); an application begins there")
        return cls(file.stem if file else name, module)

    @property
    def services(self) -> tuple[str, ...]:
        """Its services as an agent."""
        return tuple(getattr(self.module, "SERVICES", ()))

    @property
    def begins_again(self) -> bool:
        """Whether it is restarted after a failure."""
        return bool(getattr(self.module, "RESTART", False))

    @property
    def functions(self) -> list[Callable[..., Any]]:
        """The functions that the module itself defines."""
        found = [value for _, value in inspect.getmembers(self.module, inspect.isfunction)]
        return [value for value in found if value.__module__ == self.module.__name__]

    def check(self, arguments: Mapping[str, Any]) -> None:
        """Check that `main` takes these arguments beside the team.

        Raises:
            ProgramNotValid: It does not; the message says what it takes.
        """
        signature = inspect.signature(self.module.main)
        team, *others = signature.parameters
        if team in arguments:
            raise ProgramNotValid(f"{team} in main of {self.name} is its team; {_takes(others)}")
        try:
            Handler("main", self.module.main, given=(team,)).check(arguments)
        except NotUnderstood as err:
            takes = "" if "it takes" in str(err) else f"; {_takes(others)}"
            raise ProgramNotValid(f"{self.name}: {err}{takes}") from err

    def run(self, team: Any, arguments: Mapping[str, Any]) -> None:
        """Run it to its end.

        Raises:
            RobotError: An error of a robot or of the program.
        """
        try:
            self.module.main(team, **arguments)
        except RobotError:
            raise
        except Exception as err:
            raise _ProgramFailed(complaint(err, Path(str(self.module.__file__)))) from err


def _load_file(file: Path) -> ModuleType:
    file = file.resolve()
    name = f"application_{file.stem}"
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses and pickles look there
    beside = str(file.parent)
    if beside not in sys.path:
        sys.path.append(beside)  # it may import modules of its folder
    try:
        spec.loader.exec_module(module)
    except RobotError:
        raise
    except Exception as err:
        del sys.modules[name]
        raise ProgramNotValid(complaint(err, file)) from err
    return module


def _load_module(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except Exception as err:
        raise ProgramNotValid(f"the module {name} cannot be loaded: {in_words(err)}") from err


def _module_of(name: str) -> str:
    """Return the module of an application in the package."""
    folder = any(Path(place, name, "application.py").is_file() for place in importlib.import_module(PACKAGE).__path__)
    return f"{PACKAGE}.{name}.application" if folder else f"{PACKAGE}.{name}"


def _names_in_package() -> list[str]:
    return [module.name for module in pkgutil.iter_modules(importlib.import_module(PACKAGE).__path__)]


def _advice(name: str, folders: Sequence[Path]) -> str:
    """Return a suggestion for a name."""
    if name.endswith(".py"):
        known = [str(path) for path in Path(name).parent.glob("*.py")] if Path(name).parent.is_dir() else []
    else:
        known = [*_names_in_package(), *(path.stem for folder in folders for path in folder.glob("*.py"))]
        if Path(f"{name}.py").is_file():
            return f"; did you mean the file {name}.py?"
    near = meant(name, known)
    return f"; did you mean {near}?" if near else f"; write one with `acromovi new {Path(name).stem}`"


def _takes(names: Sequence[str]) -> str:
    return f"it takes {', '.join(names)}" if names else "it takes nothing"
