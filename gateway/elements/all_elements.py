"""Every element that a driver looks after, in the order in which they are asked."""

from gateway.elements.element import Element
from gateway.elements.gripper import Gripper

ELEMENTS: tuple[type[Element], ...] = (Gripper,)
