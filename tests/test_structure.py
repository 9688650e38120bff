"""The structure of the product: what `tools/structure.py` counts stays where it was brought."""

import ast
import re

import pytest

from tools.structure import Module, circles, modules, repeated_classes, small_modules, statements

API = 250
"""Names at most that packages export."""
SMALL_MODULES = 10
"""Modules at most that are small and have a single importer."""
DESCRIBED = re.compile(r"Args:\n((?:    .*\n?)+)")
ARGUMENT = re.compile(r"^    (\*{0,2}\w+(?:, \*{0,2}\w+)*):", re.MULTILINE)


@pytest.fixture(scope="module")
def known() -> dict[str, Module]:
    return modules()


def test_every_class_name_has_one_meaning(known: dict[str, Module]) -> None:
    assert repeated_classes(known) == {}


def test_no_modules_import_each_other_not_even_for_type_checkers(known: dict[str, Module]) -> None:
    assert circles(known) == []


def test_the_public_api_stays_small(known: dict[str, Module]) -> None:
    assert sum(len(module.exported()) for module in known.values() if module.is_package) <= API


def test_few_modules_are_smaller_than_a_concept(known: dict[str, Module]) -> None:
    assert len(small_modules(known)) <= SMALL_MODULES


def test_docstrings_describe_arguments_that_are_there(known: dict[str, Module]) -> None:
    strangers = []
    for module in known.values():
        for node in statements(module.tree):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                described = DESCRIBED.search(ast.get_docstring(node) or "")
                taken = {each.arg for each in ast.walk(node.args) if isinstance(each, ast.arg)}
                told = ARGUMENT.findall(described[1]) if described else []
                names = [name.strip("* ") for names in told for name in names.split(",")]
                strangers += [f"{module.name}.{node.name}: {name}" for name in names if name not in taken]
    assert strangers == []
