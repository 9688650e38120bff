"""Every face there is, in the order of the description."""

from collections.abc import Mapping
from typing import Any

from gateway.faces.cable_face import CableFace
from gateway.faces.face import Face
from gateway.faces.gripper import GripperFace

FACES: tuple[type[Face], ...] = (GripperFace,)

CABLE_FACES: Mapping[str, type[CableFace[Any]]] = {}
"""Those of elements on cables of their own, by name. The option of `p2os-gateway` is called the same."""
