"""What an operation on images is: name, kinds of image, parameters with units and ranges, and a computation.

Request forms, pages and error messages are made from it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any, Literal

from configs.suggestion import hint
from vision.image import Image, ImageKind, Pixels, VisionError

Numbers = dict[str, list[float]]
"""A result that is no image, such as a histogram."""
Arguments = Mapping[str, Any]
MAX_KERNEL = 31
"""Rows and columns that a kernel may have."""


@dataclass(frozen=True, slots=True)
class OperationParameter:
    """One parameter of an operation.

    type: `number`, `integer`, `odd` (an odd integer), `flag`, `choice`, or `matrix` (rows of numbers).
    default: None for a parameter that must be given. low, high: of a number, in `unit`. choices: of a choice.
    """

    name: str
    type: Literal["number", "integer", "odd", "flag", "choice", "matrix"]
    default: Any = None
    low: float = 0.0
    high: float = 0.0
    unit: str = ""
    choices: tuple[str, ...] = ()

    def checked(self, value: Any) -> Any:
        """Return a value in the type of the parameter: bool, int, float, str, or a tuple of tuples of floats.

        Raises:
            VisionError: It is none of the parameter.
        """
        match self.type:
            case "matrix":
                return _matrix(self.name, value)
            case "flag":
                if not isinstance(value, bool):
                    raise VisionError(f"{self.name} must be true or false, not {shown(value)}")
                return value
            case "choice":
                if value not in self.choices:
                    near = hint(value, self.choices) if isinstance(value, str) else ""
                    raise VisionError(f"{self.name} must be {self.expected}, not {shown(value)}{near}")
                return value
        if isinstance(value, bool) or not isinstance(value, int | float) or not self.low <= value <= self.high:
            raise VisionError(f"{self.name} must be {self.expected}, not {shown(value)}")
        if self.type == "number":
            return float(value) + 0.0  # no negative zero, which would make a key of its own
        if value != int(value) or (self.type == "odd" and int(value) % 2 == 0):
            raise VisionError(f"{self.name} must be {self.expected}, not {shown(value)}")
        return int(value)

    @property
    def expected(self) -> str:
        """What the parameter takes, such as `a number from 0.1 to 50 px`."""
        match self.type:
            case "matrix":
                return f"a matrix: a list of 1 to {MAX_KERNEL} rows of 1 to {MAX_KERNEL} numbers, all of one length"
            case "flag":
                return "true or false"
            case "choice":
                return " or ".join(filter(None, (", ".join(self.choices[:-1]), self.choices[-1])))
        article = {"number": "a number", "integer": "a whole number", "odd": "an odd whole number"}[self.type]
        return f"{article} from {self.low:g} to {self.high:g} {self.unit}".rstrip()

    def described(self) -> dict[str, Any]:
        """Return what a form needs, as JSON-like data."""
        form: dict[str, Any] = {"name": self.name, "type": self.type, "default": self.default}
        if self.type in ("number", "integer", "odd"):
            form |= {"low": self.low, "high": self.high, "unit": self.unit}
        if self.type == "choice":
            form["choices"] = list(self.choices)
        return form


@dataclass(frozen=True, slots=True)
class Operation:
    """A named computation on an image.

    takes: kinds of image; a binary image is taken wherever a grey one is.
    gives: the kind of the result: `same` as the input; `smooth`, as the input but grey for a binary one; `grey`;
    `binary`; or `numbers`, which end a chain.
    """

    name: str
    purpose: str
    compute: Callable[[Pixels, Arguments], Pixels | Numbers]
    parameters: tuple[OperationParameter, ...] = ()
    takes: frozenset[ImageKind] = frozenset(ImageKind)
    gives: Literal["same", "smooth", "grey", "binary", "numbers"] = "same"

    def checked(self, arguments: Mapping[str, Any]) -> dict[str, Any]:
        """Return all arguments, checked and completed with defaults, in the order of the parameters.

        Raises:
            VisionError: One is unknown, missing, or no value of its parameter.
        """
        names = [parameter.name for parameter in self.parameters]
        for name in arguments:
            if name not in names:
                near = hint(str(name), names)
                takes = ", ".join(names) or "no parameters"
                raise VisionError(f"{self.name} does not take {shown(name)}{near}; it takes {takes}")
        complete = {}
        for parameter in self.parameters:
            value = arguments.get(parameter.name, parameter.default)
            if value is None:
                raise VisionError(f"{self.name} needs {parameter.name}: {parameter.expected}")
            complete[parameter.name] = parameter.checked(value)
        return complete

    def kind_of_result(self, kind: ImageKind) -> ImageKind | None:
        """Return the kind of image that it makes of one kind; None of numbers.

        Raises:
            VisionError: It does not take that kind.
        """
        if kind not in self.takes:
            wanted = " or ".join(each.value for each in ImageKind if each in self.takes)
            remedy = "; put the operation grey before it" if ImageKind.GREY in self.takes else ""
            raise VisionError(f"{self.name} takes a {wanted} image, not a {kind.value} one{remedy}")
        match self.gives:
            case "same":
                return kind
            case "smooth":
                return ImageKind.GREY if kind is ImageKind.BINARY else kind
            case "numbers":
                return None
        return ImageKind(self.gives)

    def run(self, image: Image, arguments: Arguments) -> Image | Numbers:
        """Compute the result with arguments that `checked` returned.

        Raises:
            VisionError: It does not take the kind of the image.
        """
        kind = self.kind_of_result(image.kind)
        result = self.compute(image.pixels, arguments)
        if kind is None or isinstance(result, dict):
            assert isinstance(result, dict)
            return result
        return Image(result, kind)

    def described(self) -> dict[str, Any]:
        """Return name, purpose, kinds and parameters as JSON-like data, from which a form can be made."""
        return {
            "name": self.name,
            "purpose": self.purpose,
            "takes": [kind.value for kind in ImageKind if kind in self.takes],
            "gives": self.gives,
            "parameters": [parameter.described() for parameter in self.parameters],
        }


def shown(value: Any) -> str:
    """Return a value as an error message shows it, at most 60 characters."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:60]}…"


def _matrix(name: str, value: Any) -> tuple[tuple[float, ...], ...]:
    if not isinstance(value, list | tuple) or not 1 <= len(value) <= MAX_KERNEL:
        raise VisionError(
            f"{name} must be a list of 1 to {MAX_KERNEL} rows of numbers, such as [[0, 1, 0], [1, 4, 1], [0, 1, 0]], "
            f"not {shown(value)}"
        )
    rows = []
    for number, row in enumerate(value, 1):
        if not isinstance(row, list | tuple) or not 1 <= len(row) <= MAX_KERNEL:
            raise VisionError(f"row {number} of {name} must be a list of 1 to {MAX_KERNEL} numbers, not {shown(row)}")
        if len(row) != len(value[0]):
            raise VisionError(f"row {number} of {name} has {len(row)} numbers, and row 1 has {len(value[0])}")
        for cell in row:
            if isinstance(cell, bool) or not isinstance(cell, int | float) or not isfinite(cell) or abs(cell) > 1e6:
                raise VisionError(f"row {number} of {name} contains {shown(cell)}; use numbers from -1e6 to 1e6")
        rows.append(tuple(float(cell) for cell in row))
    return tuple(rows)
