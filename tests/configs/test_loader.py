import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any

import pytest

import configs
from configs import ConfigError
from configs.team_file import MOST_ROBOTS, read_team
from p2os import RobotModel


class Colour(Enum):
    RED = "red"
    BLUE = "blue"


@dataclass(frozen=True)
class Wheel:
    diameter_m: float
    ticks: int = 500


@dataclass(frozen=True)
class Cart:
    name: str
    speed_m_s: float
    colour: Colour = Colour.RED
    wheels: tuple[Wheel, ...] = ()
    corner: tuple[float, float] = (0.0, 0.0)
    spare: Wheel | None = None
    is_electric: bool = False
    prices: Mapping[str, float] = field(default_factory=dict)
    manual: Path | None = None
    extra: Any = None


@pytest.fixture
def cart() -> dict[str, Any]:
    return {"name": "red one", "speed_m_s": 2}


@pytest.fixture
def file_of(tmp_path: Path) -> Callable[[str | bytes], Path]:
    """A file of this text."""

    def write(text: str | bytes) -> Path:
        path = tmp_path / "cart.toml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


def test_a_file_is_found_by_its_name() -> None:
    assert configs.find("robots", "p2d8+").name == "p2d8+.toml"
    assert configs.find("robots", "p2d8+.toml") == configs.find("robots", "p2d8+")


def test_every_name_is_found() -> None:
    for kind in ("robots", "worlds", "links", "bus"):
        assert all(configs.find(kind, name).is_file() for name in configs.names(kind))
    assert len(configs.names("robots")) == 26


def test_a_path_elsewhere_is_taken_as_it_is(file_of: Callable[[str | bytes], Path]) -> None:
    path = file_of("")
    assert configs.find("robots", str(path)) == path


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("powerbotsh", "there is no 'powerbotsh' among the robots; did you mean powerbot-sh (PowerBot, SH2), "),
        ("P3DX-SH", "there is no 'P3DX-SH' among the robots; did you mean p3dx-sh (Pioneer 3-DX, SH2)?"),
        ("Pioneer 3-DX", "there is no 'Pioneer 3-DX' among the robots; did you mean p3dx (Pioneer 3-DX)?"),
        ("pioneer 3dx", "there is no 'pioneer 3dx' among the robots; did you mean p3dx (Pioneer 3-DX), "),
        ("p3xd", "there is no 'p3xd' among the robots; did you mean p3dx (Pioneer 3-DX), "),
        ("zzz", "there is no 'zzz' among the robots; choose one of amigo, "),
        ("", "there is no '' among the robots; choose one of amigo, "),
    ],
)
def test_an_unknown_name_is_answered_with_the_nearest(name: str, message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        configs.find("robots", name)
    assert str(caught.value).startswith(message)


def test_every_robot_model_has_a_full_name_of_its_own() -> None:
    full_names = [configs.full_name("robots", name) for name in configs.names("robots")]
    assert all(full_names)
    assert len(set(full_names)) == len(full_names)


def test_what_is_like_no_name_has_no_nearest() -> None:
    assert configs.nearest("robots", "zzz") == []
    assert len(configs.nearest("robots", "zzz", 0.0)) == 3


def test_a_file_without_a_full_name_is_described_by_its_name() -> None:
    assert configs.described("bus", "local") == "local"


def test_a_bus_profile_is_called_so() -> None:
    with pytest.raises(ConfigError, match="there is no 'lcal' among the bus profiles; did you mean local"):
        configs.find("bus", "lcal")


@pytest.mark.parametrize("name", ["lab/p3dx", "p3dx-of-mine.p", "office.map"])
def test_a_path_without_a_file_is_not_taken_for_a_mistyped_name(name: str) -> None:
    with pytest.raises(
        ConfigError, match=f"there is no file {name}; give one that is there, or one of the robots amigo, "
    ):
        configs.find("robots", name)


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="is a folder; give the file or one of the robots amigo, "):
        configs.find("robots", str(tmp_path))


def test_an_unknown_kind_is_refused() -> None:
    kinds = "robots, worlds, links, bus, accessories, teams or wrappers"
    with pytest.raises(ConfigError, match=f"no kind of configuration 'robot'; choose one of {kinds}"):
        configs.names("robot")


def test_bad_toml_is_reported_with_file_line_and_reason(file_of: Callable[[str | bytes], Path]) -> None:
    path = file_of('name = "x"\nspeed_m_s = \n')
    with pytest.raises(ConfigError) as caught:
        configs.read(path)
    assert str(caught.value) == f"{path} is not TOML: Invalid value (at line 2, column 13)"


def test_bytes_that_are_no_text_are_refused(file_of: Callable[[str | bytes], Path]) -> None:
    with pytest.raises(ConfigError, match="is not TOML"):
        configs.read(file_of(b"name = \xff"))


def test_a_file_that_is_gone_is_reported(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot be read: No such file or directory"):
        configs.read(tmp_path / "gone.toml")


def test_a_table_fills_a_dataclass(cart: dict[str, Any]) -> None:
    cart |= {
        "colour": "blue",
        "wheels": [{"diameter_m": 0.2}, {"diameter_m": 1, "ticks": 2}],
        "corner": [1, 2.5],
        "spare": {"diameter_m": 0.3},
        "is_electric": True,
        "prices": {"new": 100},
        "manual": "cart.pdf",
        "extra": [1, "two"],
    }
    assert configs.build(Cart, cart, "cart.toml") == Cart(
        "red one",
        2.0,
        Colour.BLUE,
        (Wheel(0.2), Wheel(1.0, 2)),
        (1.0, 2.5),
        Wheel(0.3),
        True,
        {"new": 100.0},
        Path("cart.pdf"),
        [1, "two"],
    )


def test_what_a_table_lacks_is_the_default(cart: dict[str, Any]) -> None:
    built = configs.build(Cart, cart, "cart.toml")
    assert built == Cart("red one", 2.0)
    assert isinstance(built.speed_m_s, float)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sped_m_s": 1}, "cart.toml: unknown key sped_m_s; did you mean speed_m_s?"),
        ({"spare": {"diametre_m": 1}}, "cart.toml: unknown key spare.diametre_m; did you mean spare.diameter_m?"),
        ({"wheels": [{"ticks": 1}]}, "cart.toml: key wheels[0].diameter_m is missing"),
        ({"speed_m_s": "fast"}, "cart.toml: speed_m_s must be a number, not 'fast'"),
        ({"speed_m_s": float("nan")}, "cart.toml: speed_m_s must be a number, not nan"),
        ({"speed_m_s": float("inf")}, "cart.toml: speed_m_s must be a number, not inf"),
        ({"speed_m_s": True}, "cart.toml: speed_m_s must be a number, not True"),
        ({"name": 5}, "cart.toml: name must be text, not 5"),
        ({"is_electric": 1}, "cart.toml: is_electric must be true or false, not 1"),
        ({"colour": "green"}, "cart.toml: colour must be one of red, blue, not 'green'"),
        ({"wheels": 3}, "cart.toml: wheels must be a list, not 3"),
        ({"corner": [1]}, "cart.toml: corner must hold 2 values, not [1]"),
        ({"corner": [1, "x"]}, "cart.toml: corner[1] must be a number, not 'x'"),
        ({"prices": 3}, "cart.toml: prices must be a table, not 3"),
        ({"prices": {"new": "x"}}, "cart.toml: prices.new must be a number, not 'x'"),
        ({"spare": {"diameter_m": 1, "ticks": 2.5}}, "cart.toml: spare.ticks must be a whole number, not 2.5"),
        ({"spare": 5}, "cart.toml: spare must be a table or nothing, not 5"),
    ],
)
def test_an_error_in_a_table_is_one_sentence(cart: dict[str, Any], changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        configs.build(Cart, cart | changes, "cart.toml")
    assert str(caught.value) == message


def test_null_of_json_is_nothing_and_no_value_of_anything_else(cart: dict[str, Any]) -> None:
    assert configs.build(Cart, cart | {"spare": None}, "cart.json").spare is None
    with pytest.raises(ConfigError, match="speed_m_s must be a number, not None"):
        configs.build(Cart, cart | {"speed_m_s": None}, "cart.json")


def test_a_missing_key_is_named() -> None:
    with pytest.raises(ConfigError) as caught:
        configs.build(Cart, {"name": "x"}, "cart.toml")
    assert str(caught.value) == "cart.toml: key speed_m_s is missing"


def test_only_dataclasses_are_built() -> None:
    with pytest.raises(TypeError, match="int is no dataclass"):
        configs.build(int, {}, "cart.toml")


def test_a_class_may_read_its_table_itself() -> None:
    assert configs.load(RobotModel, "robots", "p3dx-sh").name == "p3dx-sh"


def test_an_unknown_key_of_a_robot_is_reported_with_file_and_nearest_key(
    file_of: Callable[[str | bytes], Path],
) -> None:
    path = file_of(configs.find("robots", "amigo").read_text() + "[flash]\nwatchdogs_s = 3\n")
    with pytest.raises(ConfigError) as caught:
        configs.load(RobotModel, "robots", str(path))
    assert str(caught.value) == f"{path}: unknown key flash.watchdogs_s; did you mean flash.watchdog_s?"


def test_all_lists_the_public_names() -> None:
    assert sorted(configs.__all__) == [
        "ConfigError",
        "build",
        "described",
        "find",
        "full_name",
        "laid_over",
        "load",
        "names",
        "nearest",
        "read",
    ]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("a = " + "[" * 100_000 + "]" * 100_000, "nested too deeply"),
        ("a = " + "{a=" * 5000 + "1" + "}" * 5000, "nested too deeply"),
        ("a." * 30_000 + "b = 1", "a key has more than 64 levels"),
        ("[" + '"a".' * 30_000 + "b]", "a key has more than 64 levels"),
        ("x = {" + "a . " * 30_000 + "b = 1}", "a key has more than 64 levels"),
        ("a" * 900_000, "is not TOML"),
        ("a = '" + "a" * 1_000_000 + "'", "characters; at most 1000000 are read"),
        ("a = " + "9" * 5000, "is not TOML"),
    ],
)
def test_a_hostile_file_is_refused_in_one_sentence_at_once(tmp_path: Path, text: str, why: str) -> None:
    path = tmp_path / "hostile.toml"
    path.write_text(text)
    started = time.process_time()
    with pytest.raises(ConfigError, match=why) as refused:
        configs.read(path)
    assert time.process_time() - started < 2.0
    assert len(str(refused.value)) < 300


def test_a_number_that_no_float_holds_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "huge.toml"
    path.write_text('robots = [{name = "a", model = "p3dx", heading_deg = ' + "9" * 400 + "}]")
    with pytest.raises(ConfigError, match="heading_deg must be a number") as refused:
        read_team(str(path))
    assert len(str(refused.value)) < 500


def test_a_team_that_is_too_large_is_refused_at_once(tmp_path: Path) -> None:
    path = tmp_path / "crowd.toml"
    path.write_text("".join(f'[[robots]]\nname = "r{number}"\nmodel = "p3dx"\n' for number in range(5000)))
    with pytest.raises(ConfigError, match=f"a team of 5000 robots is too large; use at most {MOST_ROBOTS}"):
        read_team(str(path))


def test_changes_are_laid_over_a_table_and_leave_the_rest() -> None:
    table = {"drive": {"gap": 1.0, "speed": 0.5}, "name": "mine"}
    changed = configs.laid_over(table, {"drive": {"gap": 2.0}, "name": "yours"})
    assert changed == {"drive": {"gap": 2.0, "speed": 0.5}, "name": "yours"}
    assert table == {"drive": {"gap": 1.0, "speed": 0.5}, "name": "mine"}
