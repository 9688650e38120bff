"""Scenes of what a robot looks with: camera heads and the camera."""

import math
from pathlib import Path

from acromovi.scenes.stage import Scene, SceneStage
from bus import keys

PICTURE = Path("picture.jpg")


def _head(stage: SceneStage) -> None:
    stage.wait_for_element("ptz")
    stage.say(f"out of reach: {stage.is_refused(keys.LOOK, pan=3.0)}")
    stage.tell(keys.LOOK, pan=0.5, tilt=0.2, zoom=2.0)
    head = stage.see(
        keys.PTZ, lambda head: abs(head.pan - 0.5) < 0.02 and not head.moving, "a head that got there", 20.0
    )
    stage.say(f"pan {math.degrees(head.pan):+.1f} deg, tilt {math.degrees(head.tilt):+.1f} deg, zoom {head.zoom:.1f}")


def _camera(stage: SceneStage) -> None:
    first = stage.see(keys.CAMERA, what="a picture", within=20.0)
    PICTURE.write_bytes(bytes(first.data))
    stage.say(f"{len(first.data)} bytes of {first.format} from {stage.robots.robots[0]['camera_url']}, in {PICTURE}")
    stage.wait_for_element("ptz")
    stage.tell(keys.LOOK, pan=0.6)
    stage.see(keys.PTZ, lambda head: abs(head.pan - 0.6) < 0.02, "a head that got there", 20.0)
    second = stage.see(keys.CAMERA, lambda picture: bytes(picture.data) != bytes(first.data), "another picture")
    PICTURE.with_stem("picture-left").write_bytes(bytes(second.data))
    stage.say("the head looks to the left: the picture is another")


SCENES = (
    Scene("ptz", "a Canon VC-C4 behind AUX1", ("--robot", "p3dx-sh:{name}", "--fit", "ptz:vcc4"), _head),
    Scene("visca", "a Sony EVI-D30 behind AUX1", ("--robot", "p3dx-sh:{name}", "--fit", "ptz:evid30"), _head),
    Scene(
        "camera",
        "an IP camera on the head; leaves picture.jpg",
        ("--robot", "p3dx-sh:{name}", "--fit", "ptz:vcc4,camera:320x240@10"),
        _camera,
        ("--camera", "{camera_url}"),
    ),
)
