import ast
from pathlib import Path

from acromovi.compliance import page
from p2os.compliance import COMMAND_TEST, SOURCES, TESTS, Emulated
from p2os.packets import TABLES

ROOT = Path(__file__).parents[2]


def test_the_committed_page_is_what_the_tables_print() -> None:
    assert (ROOT / "PROTOCOL.md").read_text(encoding="utf-8") == page(), "run `make docs`"


def test_the_page_names_tests_that_exist() -> None:
    for path in {*TESTS.values(), COMMAND_TEST}:
        functions = [
            node for node in ast.walk(ast.parse((ROOT / path).read_text())) if isinstance(node, ast.FunctionDef)
        ]
        assert any(function.name.startswith("test_") for function in functions)


def test_every_packet_with_a_table_has_a_test_and_a_source() -> None:
    assert set(TABLES) <= set(TESTS)
    assert set(TABLES) <= set(SOURCES)


def test_only_what_is_emulated_is_called_emulated() -> None:
    text = Emulated({11}, {0x90}).page()
    emulated = [line.split(" | ")[0] for line in text.splitlines() if line.count("| yes ") == 3]
    assert emulated == ["| 0x90 ENCODERS", "| 11 VEL"]


def test_what_exists_only_as_a_simulator_is_marked() -> None:
    text = Emulated({11, 224}, {0x90, 0x62}, {224}, {0x62}).page()
    marked = [line.split(" | ")[0] for line in text.splitlines() if "| as simulator |" in line]
    assert marked == ["| 0x62 SIMULATOR STATE", "| 224 SIM_SET_POSE"]
