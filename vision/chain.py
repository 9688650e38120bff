"""Chains of operations: parsed from JSON-like data, checked as a whole, run in one pass, shared by key.

[{"operation": "grey"}, {"operation": "gaussian", "sigma": 2}, "otsu"]
"""

import json
from collections.abc import Mapping, MutableMapping
from dataclasses import dataclass
from itertools import accumulate
from typing import Any, Self

from configs.suggestion import hint
from vision.image import Image, ImageKind, VisionError
from vision.operation import Numbers, Operation, shown
from vision.operations import OPERATIONS

MAX_STEPS = 32
"""Operations that a chain may have."""
Results = MutableMapping[str, Image | Numbers]
"""Results for one image, by the key of the chain that gives them."""


@dataclass(frozen=True, slots=True)
class _ChainStep:
    """An operation with all its arguments."""

    operation: Operation
    arguments: Mapping[str, Any]

    @property
    def key(self) -> str:
        """Text that two steps have in common exactly if they compute the same."""
        return self.operation.name + json.dumps(self.arguments, separators=(",", ":"))


@dataclass(frozen=True, slots=True)
class Chain:
    """Operations, each on the result of the one before. kind: of the images that it takes."""

    steps: tuple[_ChainStep, ...]
    kind: ImageKind

    @classmethod
    def parse(cls, data: Any, kind: ImageKind = ImageKind.COLOUR) -> Self:
        """Return the chain that JSON-like data describes, for images of a kind.

        Args:
            data: A list of steps. A step is the name of an operation, or an object with the name under `operation` and
                its parameters beside it.
            kind: Of the image that the first operation gets.
        Raises:
            VisionError: Anything in it is wrong; the message names the step.
        """
        if not isinstance(data, list | tuple) or not 1 <= len(data) <= MAX_STEPS:
            found = f"{len(data)} of them" if isinstance(data, list | tuple) else type(data).__name__
            raise VisionError(f"a chain must be a list of 1 to {MAX_STEPS} operations, not {found}")
        steps: list[_ChainStep] = []
        current: ImageKind | None = kind
        for number, item in enumerate(data, 1):
            try:
                step = _step(item)
                if current is None:
                    raise VisionError(f"{steps[-1].operation.name} before it gives numbers and no image; put it last")
                current = step.operation.kind_of_result(current)
            except VisionError as error:
                raise VisionError(f"step {number}: {error}") from None
            steps.append(step)
        return cls(tuple(steps), kind)

    @property
    def keys(self) -> list[str]:
        """Keys of the results of all steps, the last being that of the chain.

        Equal beginnings of chains have equal keys, so what they compute can be shared.
        """
        return list(accumulate((step.key for step in self.steps), lambda left, right: f"{left} {right}"))

    @property
    def key(self) -> str:
        """Text that two chains have in common exactly if they compute the same from the same kind of image."""
        return self.keys[-1]

    @property
    def kind_of_result(self) -> ImageKind | None:
        """Kind of the image that it gives; None of numbers."""
        kind: ImageKind | None = self.kind
        for step in self.steps:
            assert kind is not None  # `parse` lets numbers be last only
            kind = step.operation.kind_of_result(kind)
        return kind

    def run(self, image: Image, results: Results | None = None) -> Image | Numbers:
        """Compute the result for an image.

        Args:
            image: Of the kind that the chain takes.
            results: Of other chains for the same image, which are used and completed; a new one for each image.
        Raises:
            VisionError: The image is of another kind.
        """
        if image.kind is not self.kind:
            raise VisionError(
                f"the chain was made for a {self.kind.value} image and got a {image.kind.value} one; parse it for that"
            )
        known: Results = {} if results is None else results
        keys = self.keys
        done = next((count for count in range(len(keys), 0, -1) if keys[count - 1] in known), 0)
        current: Image | Numbers = known[keys[done - 1]] if done else image
        for step, key in zip(self.steps[done:], keys[done:], strict=True):
            assert isinstance(current, Image)  # `parse` lets numbers be last only
            current = known[key] = step.operation.run(current, step.arguments)
        return current

    def described(self) -> list[dict[str, Any]]:
        """Return the steps with all parameters as JSON-like data, which `parse` reads."""
        return [{"operation": step.operation.name, **json.loads(json.dumps(step.arguments))} for step in self.steps]


def _step(item: Any) -> _ChainStep:
    if isinstance(item, str):
        item = {"operation": item}
    if not isinstance(item, Mapping) or "operation" not in item:
        raise VisionError('a step must be a name or an object such as {"operation": "gaussian", "sigma": 2}')
    operation = _operation(item["operation"])
    return _ChainStep(
        operation, operation.checked({name: value for name, value in item.items() if name != "operation"})
    )


def _operation(name: object) -> Operation:
    if isinstance(name, str) and name in OPERATIONS:
        return OPERATIONS[name]
    near = hint(name, OPERATIONS) if isinstance(name, str) else ""
    known = "" if near else f"; the operations are {', '.join(OPERATIONS)}"
    raise VisionError(f"there is no operation {shown(name)}{near}{known}")
