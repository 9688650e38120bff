"""Scenes of cables and their faults."""

import time
from typing import Any

from acromovi.scenes.stage import Scene, SceneFailed, SceneStage
from bus import keys

COUNTED_S = 3.0


def _rate(stage: SceneStage) -> None:
    count = 0
    began = time.monotonic()

    def is_over(_: object) -> bool:
        nonlocal count
        count += 1
        return time.monotonic() - began >= COUNTED_S

    stage.see(keys.ODOM, is_over, "odometry", 3 * COUNTED_S)
    seconds = time.monotonic() - began
    cable = stage.see(keys.DIAGNOSTICS).status[1]
    stage.say(f"{count / seconds:.1f} poses a second; cable: {cable.message}")


def _cut(stage: SceneStage) -> None:
    stage.ask("fault", fault="line-cut@0+3")
    state = stage.see(keys.STATE, lambda state: state.connection != "connected", "a state without connection")
    stage.say(f"{state.connection}: {'; '.join(state.faults)}")
    why = stage.is_refused(keys.MOVE, distance=1.0)
    stage.say(f"a command meanwhile: {why}")
    stage.see(keys.STATE, lambda state: state.connection == "connected", "the robot back", 15.0)
    stage.say("the cable is back, and so is the robot")


def _noise(stage: SceneStage) -> None:
    stage.ask("fault", fault="line-noisy@0+5")

    def is_damaged(message: Any) -> bool:
        values = message.status[1].values
        return any(value.key.startswith("damaged") for value in values)

    cable = stage.see(keys.DIAGNOSTICS, is_damaged, "a damaged frame in the diagnostics").status[1]
    stage.say(f"{cable.message}: {', '.join(f'{value.key} {value.value}' for value in cable.values)}")
    pose = stage.see(keys.ODOM).pose.pose.position
    if abs(pose.x) > 0.01 or abs(pose.y) > 0.01:
        raise SceneFailed("a damaged frame moved the odometry")
    stage.say("the odometry stands where the robot stands")


SCENES = (
    Scene("rs232", "a cable of 9600 baud", "--robot p3dx-sh:{name} --link rs232", _rate),
    Scene("usb-serial", "the same with a USB adapter", "--robot p3dx-sh:{name} --link usb-serial", _rate),
    Scene(
        "radio-modem",
        "radio modems between robot and gateway",
        "--robot p3dx-sh:{name} --link radio-modem",
        _rate,
        "--radio",
    ),
    Scene("line-cut", "the cable is cut for 3 s", "--robot p3dx-sh:{name}", _cut),
    Scene("line-noisy", "bits on the cable turn round", "--robot p3dx-sh:{name}", _noise),
)
