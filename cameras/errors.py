"""What can go wrong with a camera.

    CameraError
     +-- CameraNotUsable                 it is written wrong, or a part of the installation is missing
     +-- CameraLost (ConnectionError)    it is not there, or gives no pictures

One that is lost may come back, and whoever wants its pictures opens it again.
"""


class CameraError(Exception):
    """Base class of the errors of cameras. The message says what to do."""


class CameraNotUsable(CameraError):
    """The address of the camera is not valid, or a package that is needed to open it is not installed."""


class CameraLost(CameraError, ConnectionError):
    """The camera cannot be reached, or sends no pictures."""
