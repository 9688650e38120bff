"""What a handler tells of its parameters."""

import json
from collections.abc import Mapping
from math import inf
from typing import Any

from agents.platform.conversations.handler import Handler

NONE: Mapping[str, Any] = {}


def drive(
    linear: float, speed: float | None = None, table: Mapping[str, Any] = NONE, far: float = inf, **m: int
) -> None:
    """Drive.

    Units are SI.
    """


def test_a_handler_describes_documentation_types_and_defaults() -> None:
    told = Handler("drive", drive).describe()
    assert told["doc"] == "Drive.\n\nUnits are SI."
    assert told["takes_any"]
    assert told["parameters"] == [
        {"name": "linear", "type": "float"},
        {"name": "speed", "type": "float | None", "default": None},
        {"name": "table", "type": "Mapping[str, typing.Any]", "default": None},
        {"name": "far", "type": "float", "default": None},
    ]


def test_a_description_is_json_and_leaves_out_what_the_initiator_does_not_give() -> None:
    told = Handler("drive", drive, given=("linear",)).describe()
    assert json.loads(json.dumps(told)) == told
    assert [each["name"] for each in told["parameters"]] == ["speed", "table", "far"]
