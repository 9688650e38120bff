"""The example that others copy, run as they would run it."""

import ast
import re
import shutil
import sys
from pathlib import Path

from tests.waiting import run

ROOT = Path(__file__).parents[1]
EXAMPLE = ROOT / "examples" / "foreign-driver"
LEFTOVERS = shutil.ignore_patterns("__pycache__", ".pytest_cache", "*.egg-info")
LIMIT = 110.0  # s; it takes about ten


def test_foreign_driver_passes_its_tests_on_emulated_robots(tmp_path: Path) -> None:
    copy = tmp_path / "driver"
    shutil.copytree(EXAMPLE, copy, ignore=LEFTOVERS)
    command = [sys.executable, "-m", "pytest", "-n", "3", "-p", "no:cacheprovider"]  # its robots mostly wait
    done = run(command, LIMIT, cwd=copy)
    assert done.returncode == 0, done.stdout + done.stderr
    assert " passed" in done.stdout


def test_foreign_driver_is_foreign() -> None:
    rooms = {init.parent.name for init in ROOT.glob("*/__init__.py")}
    for source in EXAMPLE.rglob("*.py"):
        for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import | ast.ImportFrom):
                names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else [node.module or ""]
                assert not {name.partition(".")[0] for name in names} & rooms, source.name


def test_ci_of_the_example_installs_what_its_readme_says() -> None:
    ci, readme = ((EXAMPLE / name).read_text() for name in (".github/workflows/ci.yml", "README.md"))
    assert 'pip install -e . "$ACROMOVI" pytest pytest-timeout' in ci
    (source,) = re.findall(r'ACROMOVI: "(.*)"', ci)
    assert f'`"{source}"`' in readme


def test_source_of_acromovi_in_the_example_s_install_command_is_this_checkout() -> None:
    (source,) = re.findall(
        r'^pip install -e \. "(.*)\[emu\]" pytest', (EXAMPLE / "README.md").read_text(), re.MULTILINE
    )
    assert (EXAMPLE / source / "pyproject.toml").resolve() == ROOT / "pyproject.toml"
