"""The structure of the product: what `tools/structure.py` counts stays where it was brought."""

import pytest

from tools.structure import Module, circles, modules, repeated_classes

API = 250
"""Names at most that packages export."""


@pytest.fixture(scope="module")
def known() -> dict[str, Module]:
    return modules()


def test_every_class_name_has_one_meaning(known: dict[str, Module]) -> None:
    assert repeated_classes(known) == {}


def test_no_modules_import_each_other_not_even_for_type_checkers(known: dict[str, Module]) -> None:
    assert circles(known) == []


def test_the_public_api_stays_small(known: dict[str, Module]) -> None:
    assert sum(len(module.exported()) for module in known.values() if module.is_package) <= API
