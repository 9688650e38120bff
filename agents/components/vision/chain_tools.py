"""Chains of operations on images of the bus. Loads OpenCV."""

import base64
import json
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Any

from agents.components.camera import MOST
from agents.components.vision.image_tools import ImageTools
from cameras import CameraNotUsable, shrunk
from configs.suggestion import hint
from vision.chain import Chain, Results
from vision.image import Image, ImageKind, VisionError
from vision.operation import Numbers, shown
from vision.operations import OPERATIONS

Steps = list[dict[str, Any]]

_QUALITY = 90  # of a JPEG


class ChainTools(ImageTools):
    """Runs chains; each begins where another one has computed the same for the same image."""

    def operations(self) -> list[dict[str, Any]]:
        """Return all operations with their parameters."""
        return [operation.described() for operation in OPERATIONS.values()]

    def operation(self, name: str, parameters: Mapping[str, Any], saved: Iterable[str]) -> tuple[Steps, bool]:
        """Return the chain of one operation as `checked` does.

        Args:
            name: Of the operation.
            parameters: Of it, by name.
            saved: Names of chains that exist, for the error.
        Raises:
            VisionError: There is no such operation, or a parameter is wrong.
        """
        if name not in OPERATIONS:
            near = hint(name, [*OPERATIONS, *saved])
            known = ", ".join(saved) or "none"
            raise VisionError(f"there is no chain or operation {shown(name)}{near}; saved chains: {known}")
        return self.checked([{**parameters, "operation": name}])

    def checked(self, chain: Any) -> tuple[Steps, bool]:
        """Return the steps of a chain with all parameters, and whether it gives numbers.

        Raises:
            VisionError: It can be used neither for colour images nor for grey ones.
        """
        try:
            parsed = Chain.parse(chain)
        except VisionError as err:
            try:
                parsed = Chain.parse(chain, ImageKind.GREY)
            except VisionError:
                raise err from None
        return parsed.described(), parsed.kind_of_result is None

    def run(self, steps: Steps, image: Image, results: Results) -> Image | Numbers:
        """Return the result of a chain, and add what was computed to the results for this image.

        Raises:
            VisionError: The chain does not take an image of this kind.
        """
        return _chain(json.dumps(steps), image.kind).run(image, results)

    def encoded(self, image: Image, quality: int = _QUALITY) -> tuple[str, bytes]:
        """Return the format and the file of an image: JPEG, and PNG for a binary image or the quality 0."""
        is_png = image.kind is ImageKind.BINARY or quality == 0
        return ("png", image.encode()) if is_png else ("jpeg", image.encode(quality))

    def picture(self, image: Image, quality: int) -> dict[str, Any]:
        """Return an image as the result of a request: in base64, reduced in size if it is too large for a message.

        Raises:
            VisionError: The quality is none, or the image cannot be reduced enough.
        """
        name, data = self.encoded(image, quality)
        width, height = image.width, image.height
        if len(data) > MOST:
            try:
                data = shrunk(data, MOST)
            except CameraNotUsable as err:
                raise VisionError(f"the result of {len(data) // 1000} kB does not fit into a message ({err})") from err
            name, small = "jpeg", Image.decode(data)
            width, height = small.width, small.height
        return {
            "format": name,
            "kind": image.kind.value,
            "width": width,
            "height": height,
            "data": base64.b64encode(data).decode(),
        }


@lru_cache(maxsize=256)
def _chain(steps: str, kind: ImageKind) -> Chain:
    return Chain.parse(json.loads(steps), kind)
