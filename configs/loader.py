"""From a name to a file, from a file to a table, from a table to a frozen dataclass; every error in one sentence."""

import difflib
import math
import re
import tomllib
import types
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from configs.parameter_file import ParameterError, parse

T = TypeVar("T")

SUFFIX = ".toml"
PARAMETER_SUFFIX = ".p"
LARGEST_EXACT = 2**53  # integers that a float holds exactly
LARGEST_FILE = 1_000_000  # bytes of TOML; a thousand times what any file here has, and parsed in less than a second
LONGEST_QUOTE = 200  # characters of a value in an error
MAX_DEPTH = 64  # levels of a dotted key; lists and tables end where Python's parser ends
FILE_SUFFIXES = (SUFFIX, PARAMETER_SUFFIX, ".map")
KINDS = ("robots", "worlds", "links", "bus", "accessories", "teams", "wrappers")
_CALLED = {"bus": "bus profiles"}
# The time that tomllib needs for a key grows with the square of its levels.
_KEY = r"""(?:(?<![\w-])[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+"""
_DEEP_KEY = re.compile(rf"(?:{_KEY}\.[ \t]*+){{{MAX_DEPTH}}}")


class ConfigError(ValueError):
    """A configuration that cannot be used; the message says which file, what is wrong and what to do."""


def names(kind: str) -> list[str]:
    """The names of the files of one of `KINDS`, sorted."""
    return sorted(path.stem if path.suffix == SUFFIX else path.name for path in _files(kind))


def find(kind: str, name: str) -> Path:
    """The file that a name means.

    Args:
        kind: One of `KINDS`.
        name: Of a file in this package, or a path to one elsewhere.
    Raises:
        ConfigError: There is no such file; the message gives the nearest names.
    """
    files = _files(kind)
    if not isinstance(name, str):
        raise ConfigError(f"a name of {_CALLED.get(kind, kind)} is a text, not {name!r}")
    for path in files:
        if name in (path.name, path.stem):
            return path
    elsewhere = Path(name)
    if elsewhere.is_file():
        return elsewhere
    called = _CALLED.get(kind, kind)
    if name and elsewhere.is_dir():
        raise ConfigError(f"{name} is a folder; give the file or one of the {called} {_listed(names(kind))}")
    if elsewhere.name != name or elsewhere.suffix in FILE_SUFFIXES:
        raise ConfigError(
            f"there is no file {name}; give one that is there, or one of the {called} {_listed(names(kind))}"
        )
    near = [described(kind, each) for each in nearest(kind, name)] if name else []
    hint = f"did you mean {_listed(near)}?" if near else f"choose one of {_listed(names(kind))}"
    raise ConfigError(f"there is no {name!r} among the {called}; {hint}")


def nearest(kind: str, name: str, likeness: float = 0.4) -> list[str]:
    """The names that are spelt most like one, by the name itself or by the full name that the file gives.

    Args:
        kind: One of `KINDS`.
        name: What somebody wrote, `pioneer 3dx` for example.
        likeness: 0 to 1; what is less like it is left out.
    Returns:
        At most three, the nearest first; only one when that is the same but for upper and lower case.
    """
    known = {full_name(kind, each).lower(): each for each in names(kind)} | {each: each for each in names(kind)}
    wanted = str(name).lower()
    if wanted in known:
        return [known[wanted]]
    return list(dict.fromkeys(known[text] for text in difflib.get_close_matches(wanted, known, 6, likeness)))[:3]


def described(kind: str, name: str) -> str:
    """A name with its full name, as `p3dx (Pioneer 3-DX)`; without, where its file gives none."""
    full = full_name(kind, name)
    return f"{name} ({full})" if full else name


def full_name(kind: str, name: str) -> str:
    """What people call one of the files of a kind, `Pioneer 3-DX`; empty where the file does not say."""
    path = find(kind, name)
    return str(read(path).get("full_name", "")) if path.suffix == SUFFIX else ""


def read(path: str | Path) -> dict[str, Any]:
    """Parse a TOML file, or a robot's parameter file (`.p`) as ARIA's programs keep them.

    Raises:
        ConfigError: The file cannot be read or has an error; the message names file, line and reason.
    """
    path = Path(path)
    try:
        if path.suffix == PARAMETER_SUFFIX:
            return parse(path.read_text(encoding="latin-1"), lambda name: read(find("robots", name)), names("robots"))
        return _parse_toml(path)
    except OSError as err:
        raise ConfigError(f"{path} cannot be read: {err.strerror}") from err
    except ParameterError as err:
        raise ConfigError(f"{path}: {err}") from err
    except RecursionError as err:
        raise ConfigError(f"{path} is nested too deeply; no table here has more than a few levels") from err
    except ConfigError:
        raise
    except ValueError as err:  # no TOML, no UTF-8, or a number of thousands of digits
        raise ConfigError(f"{path} is not TOML: {err}") from err


def laid_over(table: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table with changes; where both have a table, that is changed in the same way."""
    merged = dict(table)
    for key, value in changes.items():
        below = table.get(key)
        merged[key] = laid_over(below, value) if isinstance(below, Mapping) and isinstance(value, Mapping) else value
    return merged


def _parse_toml(path: Path) -> dict[str, Any]:
    text = path.read_text(encoding="utf-8")
    if len(text) > LARGEST_FILE:
        raise ConfigError(f"{path} has {len(text)} characters; at most {LARGEST_FILE} are read")
    if _DEEP_KEY.search(text):
        raise ConfigError(f"{path} is nested too deeply: a key has more than {MAX_DEPTH} levels")
    return tomllib.loads(text)


def load(cls: type[T], kind: str, name: str) -> T:
    """Find, read and build in one go.

    Raises:
        ConfigError: As `find`, `read` and `build`.
    """
    path = find(kind, name)
    return build(cls, read(path), str(path))


def build(cls: type[T], table: Mapping[str, Any], source: str) -> T:
    """Fill a frozen dataclass from a table.

    A class with a `from_table` reads the table itself. In any other a key is a field's name; nested tables fill nested
    dataclasses, lists fill tuples, whole numbers fill floats.

    Args:
        cls: What to build.
        table: Parsed TOML.
        source: Named in messages, usually the file.
    Raises:
        ConfigError: A key is unknown or missing, or a value has the wrong type.
    """
    if not isinstance(table, Mapping):
        raise ConfigError(f"{source}: a table is needed, not {table!r}")
    from_table: Callable[[Mapping[str, Any]], T] | None = getattr(cls, "from_table", None)
    if from_table is None:
        return _build_dataclass(cls, table, source, "")
    try:
        return from_table(table)
    except ValueError as err:
        raise ConfigError(f"{source}: {err}") from err


def _build_dataclass(cls: type[T], table: Mapping[str, Any], source: str, path: str) -> T:
    if not is_dataclass(cls):
        name = getattr(cls, "__name__", repr(cls))
        raise TypeError(f"{name} is no dataclass and has no from_table; give a class such as p2os.RobotModel")
    kinds = get_type_hints(cls)
    hints = {field.name: kinds[field.name] for field in fields(cls)}
    for key in table:
        if key not in hints:
            nearest = difflib.get_close_matches(key, hints, 1, 0)
            raise ConfigError(f"{source}: unknown key {path}{key}; did you mean {path}{nearest[0]}?")
    for field in fields(cls):
        if field.name not in table and field.default is MISSING and field.default_factory is MISSING:
            raise ConfigError(f"{source}: key {path}{field.name} is missing")
    return cls(**{key: _convert(hints[key], value, source, path + key) for key, value in table.items()})


def _convert(kind: Any, value: Any, source: str, path: str) -> Any:
    """Turn a TOML value into a field's type."""
    origin = get_origin(kind)
    if origin in (Union, types.UnionType):
        return _convert_union(kind, value, source, path)
    if origin is tuple and isinstance(value, list):
        return _convert_tuple(get_args(kind), value, source, path)
    if origin in (dict, Mapping) or kind is dict:
        if isinstance(value, dict):
            item = get_args(kind)[1] if get_args(kind) else Any
            return {key: _convert(item, each, source, f"{path}.{key}") for key, each in value.items()}
    elif isinstance(kind, type) and is_dataclass(kind) and isinstance(value, dict):
        return _build_dataclass(kind, value, source, path + ".")
    elif kind is Any:
        return value
    elif isinstance(kind, type):
        converted = _convert_plain(kind, value)
        if converted is not None:
            return converted
    raise ConfigError(f"{source}: {path} must be {_type_name(kind)}, not {_shown(value)}")


def _convert_plain(kind: type, value: Any) -> Any:
    """A bool, finite number, string or enumeration member; None where the value is of another type."""
    if isinstance(value, bool):
        return value if kind is bool else None
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if kind is float and isinstance(value, int):
        return float(value) if abs(value) < LARGEST_EXACT else None
    if kind is Path and isinstance(value, str):
        return Path(value)
    if isinstance(value, kind):
        return value
    members = getattr(kind, "__members__", {})
    return next((member for member in members.values() if member.value == value), None)


def _convert_union(kind: Any, value: Any, source: str, path: str) -> Any:
    if value is None and types.NoneType in get_args(kind):  # JSON has such a value, TOML has not
        return None
    tables = [option for option in get_args(kind) if is_dataclass(option)]
    if isinstance(value, dict) and len(tables) == 1:
        return _convert(tables[0], value, source, path)
    for option in get_args(kind):
        try:
            return _convert(option, value, source, path)
        except ConfigError:
            continue  # not this alternative; if none fits, the error below tells
    raise ConfigError(f"{source}: {path} must be {_type_name(kind)}, not {_shown(value)}")


def _convert_tuple(items: Sequence[Any], values: list[Any], source: str, path: str) -> tuple[Any, ...]:
    if len(items) == 2 and items[1] is Ellipsis:
        items = [items[0]] * len(values)
    if len(items) != len(values):
        raise ConfigError(f"{source}: {path} must hold {len(items)} values, not {values!r}")
    return tuple(
        _convert(item, each, source, f"{path}[{i}]") for i, (item, each) in enumerate(zip(items, values, strict=True))
    )


def _shown(value: Any) -> str:
    """A value as an error quotes it; whole files may stand where a number belongs."""
    text = repr(value)
    return text if len(text) <= LONGEST_QUOTE else text[: LONGEST_QUOTE - 1] + "…"


def _files(kind: str) -> list[Path]:
    if kind not in KINDS:
        raise ConfigError(f"there is no kind of configuration {kind!r}; choose one of {_listed(KINDS)}")
    folder = Path(__file__).parent / kind
    return sorted(path for path in folder.glob("*") if path.is_file()) if folder.is_dir() else []


def _listed(words: Sequence[str]) -> str:
    return ", ".join(words[:-1]) + " or " + words[-1] if len(words) > 1 else "".join(words)


def _type_name(kind: Any) -> str:
    plain = {float: "a number", int: "a whole number", str: "text", bool: "true or false", type(None): "nothing"}
    if kind in plain:
        return plain[kind]
    if get_origin(kind) in (Union, types.UnionType):
        return " or ".join(_type_name(option) for option in get_args(kind))
    if get_origin(kind) is tuple:
        return "a list"
    members = getattr(kind, "__members__", None)
    if members:
        return "one of " + ", ".join(str(member.value) for member in members.values())
    return "a table" if is_dataclass(kind) or get_origin(kind) in (dict, Mapping) else str(kind)
