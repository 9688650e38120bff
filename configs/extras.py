"""The extras of the distribution: which modules each one brings, what needs it, and how to install it."""

import json
import shlex
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import unquote, urlsplit

from configs.loader import ConfigError

DISTRIBUTION = "acromovi"
CHECKOUT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True, slots=True)
class _Extra:
    """One extra.

    modules: that it installs. purpose: what needs them.
    """

    modules: tuple[str, ...]
    purpose: str


EXTRAS = {
    "emu": _Extra(("pybullet", "PIL"), "the emulator"),
    "plots": _Extra(("matplotlib",), "pictures of drives and missions"),
    "vision": _Extra(("cv2",), "camera devices and the pixels of pictures"),
    "security": _Extra(("cryptography",), "a secure bus"),
    "recorder": _Extra(("mcap",), "recordings"),
    "console": _Extra(("nicegui",), "pages in a browser"),
}


class ExtraMissing(ConfigError, ModuleNotFoundError):
    """An extra is not installed; the message contains the command that installs it."""


def missing(*extras: str) -> list[str]:
    """Return those extras of which a module is not installed."""
    return [extra for extra in extras if not all(map(_is_installed, EXTRAS[extra].modules))]


def require(what: str, *extras: str) -> None:
    """Check that extras are installed, before a module of theirs is imported.

    Args:
        what: What needs them, the subject of the message.
        extras: Of `EXTRAS`.
    Raises:
        ExtraMissing: A module of one of them is not installed.
    """
    if lacking := missing(*extras):
        raise ExtraMissing(needs(what, *lacking))


def needs(what: str, *extras: str) -> str:
    """Return the sentence that says which extras are needed, and how to install them."""
    named = f"the extra{'s' if len(extras) > 1 else ''} {' and '.join(extras)}"
    return f"{what} needs {named}, not installed here; install with: {install_command(*extras)}"


def install_command(*extras: str) -> str:
    """Return the command that installs extras into this environment, from the source of this installation."""
    return f"{shlex.quote(sys.executable)} -m pip install {_source(','.join(extras))}"


def _source(extras: str) -> str:
    """Return what pip is given for extras: the checkout, wheel or repository from which this distribution came."""
    from importlib.metadata import PackageNotFoundError, distribution  # only for an error: it is a large module

    try:
        origin = json.loads(distribution(DISTRIBUTION).read_text("direct_url.json") or "{}")
    except PackageNotFoundError:  # run from a checkout
        origin = {"url": CHECKOUT.as_uri(), "dir_info": {"editable": True}}
    url = str(origin.get("url", ""))
    match origin:
        case {"dir_info": {"editable": True}}:
            return f"-e {shlex.quote(f'{_path(url)}[{extras}]')}"
        case {"dir_info": _}:
            return shlex.quote(f"{_path(url)}[{extras}]")
        case {"vcs_info": {"vcs": str(system), "commit_id": str(commit)}}:
            return shlex.quote(f"{DISTRIBUTION}[{extras}] @ {system}+{url}@{commit}")
        case {"archive_info": _}:
            return shlex.quote(f"{DISTRIBUTION}[{extras}] @ {url}")
    return shlex.quote(f"{DISTRIBUTION}[{extras}]")


def _path(url: str) -> str:
    return unquote(urlsplit(url).path)


def _is_installed(module: str) -> bool:
    return find_spec(module) is not None
