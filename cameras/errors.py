"""What can go wrong with a camera.

    CameraError
     +-- CameraNotUsable                 it is written wrong, or a part of the installation is missing
     +-- CameraLost (ConnectionError)    it is not there, or gives no pictures

One that is lost may come back, and whoever wants its pictures opens it again.
"""


class CameraError(Exception):
    """The root. The message is one sentence that says what to do."""


class CameraNotUsable(CameraError):
    """The camera is written wrong, or something is missing to open it."""


class CameraLost(CameraError, ConnectionError):
    """The camera is not there, or gives no pictures."""
