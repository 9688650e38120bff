"""Every face there is, in the order of the description."""

from gateway.faces.face import Face

FACES: tuple[type[Face], ...] = ()
