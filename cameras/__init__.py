"""Cameras beside the robot's line: an IP camera at a URL, or a device of this computer. They deliver JPEG files."""

from cameras.errors import CameraError, CameraLost, CameraNotUsable
from cameras.jpeg import picture_size, shrunk
from cameras.multipart import CameraPicture
from cameras.reader import CameraFrame, CameraReader
from cameras.source import CameraSource, check_source, open_source

__all__ = [
    "CameraError",
    "CameraFrame",
    "CameraLost",
    "CameraNotUsable",
    "CameraPicture",
    "CameraReader",
    "CameraSource",
    "check_source",
    "open_source",
    "picture_size",
    "shrunk",
]
