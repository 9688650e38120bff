"""Forms of operations: what the agent describes becomes fields, and what is entered a chain that the agent takes."""

from typing import Any

import pytest

from apps.remote_vision.operations import EntryNotValid, chain_of, entered, expected, initial_value
from vision.chain import Chain
from vision.operations import OPERATIONS

DESCRIBED = {name: operation.described() for name, operation in OPERATIONS.items()}
SIZE = {"name": "size", "type": "odd", "default": 3, "low": 1, "high": 99, "unit": "px"}
KERNEL = {"name": "kernel", "type": "matrix", "default": None}


@pytest.mark.parametrize("operation", DESCRIBED.values(), ids=DESCRIBED)
def test_the_fields_as_they_begin_make_a_chain_for_an_image_in_colour(operation: dict[str, Any]) -> None:
    values = {each["name"]: initial_value(each) for each in operation["parameters"]}
    Chain.parse(chain_of(operation, values))


def test_an_operation_is_done_after_the_steps_before_it() -> None:
    before = chain_of(DESCRIBED["threshold"], {"level": 90, "invert": False})
    assert [step["operation"] for step in before] == ["grey", "threshold"]
    chain = chain_of(DESCRIBED["opening"], {"size": 3, "shape": "cross", "passes": 1}, before)
    assert [step["operation"] for step in chain] == ["grey", "threshold", "opening"]
    Chain.parse(chain)


@pytest.mark.parametrize(
    ("parameter", "value", "why"),
    [
        (SIZE, None, "size is empty; enter an odd whole number from 1 to 99 px"),
        (SIZE, 3.5, "size is 3.5; enter an odd whole number"),
        (KERNEL, "[[1, 2", "kernel is not a matrix; enter rows of numbers"),
        (KERNEL, "", "kernel is empty; enter rows of numbers"),
    ],
)
def test_what_is_no_value_is_refused_in_words(parameter: dict[str, Any], value: Any, why: str) -> None:
    with pytest.raises(EntryNotValid, match=why[:40].replace(".", r"\.").replace("[", r"\[")):
        entered(parameter, value)


def test_values_come_as_the_agent_takes_them() -> None:
    assert entered(SIZE, 5.0) == 5
    assert isinstance(entered(SIZE, 5.0), int)
    assert entered(KERNEL, "[[1, 2], [3, 4]]") == [[1, 2], [3, 4]]
    assert entered({"name": "shape", "type": "choice"}, "cross") == "cross"
    assert expected({"name": "shape", "type": "choice"}) == "a value"
