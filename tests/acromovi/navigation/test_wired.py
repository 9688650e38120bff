"""What runs in which process, by the wiring file and the command line."""

import argparse
from pathlib import Path

import pytest

from acromovi.navigation.launch import of_names
from acromovi.navigation.wired import add_wiring, nested, processes, words
from apps.indoor_navigation.parameters import WIRING
from apps.indoor_navigation.wiring import load_wiring
from configs import ConfigError


def options(*given: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_wiring(parser)
    return parser.parse_args(given)


def names(*given: str) -> dict[str, list[str]]:
    return {process: [part.local for part in parts] for process, parts in processes(options(*given)).items()}


def test_components_run_where_the_file_says() -> None:
    wiring = load_wiring()
    assert list(names()) == list(wiring.processes)
    assert names()["hardware"] == ["robot_base_server", "laser_server"]


def test_each_component_may_have_a_process_of_its_own_or_all_share_one() -> None:
    every = [part.local for part in load_wiring().parts]
    assert names("--processes", "each") == {local: [local] for local in every}
    assert names("--processes", "one") == {"navigation": every}


def test_numbers_are_changed_on_the_command_line() -> None:
    parts = processes(options("--set", "components.laser_server.numbers.no_scan=2.5"))["hardware"]
    (laser,) = (part for part in parts if part.local == "laser_server")
    assert laser.properties["numbers"]["no_scan"] == 2.5


def test_a_mistake_in_a_change_is_told() -> None:
    with pytest.raises(ConfigError, match="did you mean no_scan"):
        processes(options("--set", "components.laser_server.numbers.no_scn=2.5"))


def test_a_change_inside_of_a_value_is_refused() -> None:
    with pytest.raises(ConfigError, match="numbers has been given a value already"):
        nested([("components.goto.numbers", 1), ("components.goto.numbers.speed", 2)])


def test_another_file_is_read(tmp_path: Path) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text(WIRING.read_text().replace('process = "hardware"', 'process = "iron"'))
    assert "iron" in names("--wiring", str(mine))
    with pytest.raises(ConfigError, match=r"nowhere\.toml"):
        names("--wiring", str(tmp_path / "nowhere.toml"))


def test_the_same_options_give_the_same_processes_in_a_child() -> None:
    given = options("--processes", "each", "--set", "components.laser_server.numbers.no_scan=2.5")
    assert vars(options(*words(given))) == vars(given)


def test_single_processes_are_chosen_by_name() -> None:
    known = processes(options())
    assert list(of_names(known, ["hardware"])) == ["hardware"]
    assert list(of_names(known, [])) == list(known)
    with pytest.raises(ConfigError, match="has no process 'hardwear'; choose one of hardware"):
        of_names(known, ["hardwear"])
