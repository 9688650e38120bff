"""The table of elements: what every row of it must have."""

import subprocess
import sys

import pytest

from gateway.elements.adapter import adapter_types
from gateway.elements.all_elements import ELEMENTS, ElementRow

SLOW_TO_LOAD = (
    "bus",
    "numpy",
    "zenoh",
    "cameras",
    "gateway.elements.laser.driver",
    "gateway.elements.powercube.driver",
)


@pytest.mark.parametrize("row", ELEMENTS, ids=lambda row: row.folder)
def test_every_row_has_bus_adapters_whose_elements_are_its_own(row: ElementRow) -> None:
    adapters = adapter_types(row)
    assert adapters
    if row.cable is None:
        assert {adapter.element for adapter in adapters} - {None} <= set(row.elements)


@pytest.mark.parametrize("row", [row for row in ELEMENTS if row.cable is not None], ids=lambda row: row.folder)
def test_element_on_a_cable_of_its_own_has_one_adapter_named_as_its_option(row: ElementRow) -> None:
    (adapter,) = adapter_types(row)
    assert row.cable is not None
    assert adapter.name == row.cable.name


def test_no_element_is_in_the_table_twice() -> None:
    elements = [element for row in ELEMENTS for element in row.elements]
    assert len(elements) == len(set(elements))
    assert len({row.folder for row in ELEMENTS}) == len(ELEMENTS)


def test_gateway_starts_without_loading_the_bus_and_what_no_option_asks_for() -> None:
    program = f"import sys, gateway.__main__; print(*sys.modules.keys() & {set(SLOW_TO_LOAD)})"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
