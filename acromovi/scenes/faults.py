"""Scenes of faults, and of how the gateway reports them."""

import math
from typing import Any

from acromovi.scenes.stage import MOST_MOTIONS, Scene, SceneFailed, SceneStage
from bus import keys

STALL_S = 8.0  # s; a wheel that is driven stalls in less than one


def _stalled(stage: SceneStage) -> None:
    def is_stalled(state: Any) -> bool:
        return any("stalled" in fault for fault in state.faults)

    for left in reversed(range(MOST_MOTIONS)):
        stage.ask("fault", fault=f"wheel-stalled:side=left@0+{STALL_S:g}")
        stage.tell(keys.MOVE, distance=1.0)
        try:
            state = stage.see(keys.STATE, is_stalled, "a stalled wheel", STALL_S)
        except SceneFailed:
            if not left:
                raise
        else:
            stage.say("; ".join(state.faults))
            return


def _dead_disc(stage: SceneStage) -> None:
    disc = f"{stage.robot}/sonar_3"

    def hears(message: Any) -> bool:
        readings = message.ranges
        return any(one.header.frame_id == disc and math.isinf(one.range) == is_dead for one in readings)

    is_dead = False
    stage.see(keys.SONAR, hears, "an echo of disc 3")
    stage.ask("fault", fault="sonar-dead:disc=3@0+5")
    is_dead = True
    stage.see(keys.SONAR, hears, "silence of disc 3")
    stage.say("disc 3 hears nothing: its range is infinite")
    is_dead = False
    stage.see(keys.SONAR, hears, "disc 3 back", 15.0)
    stage.say("disc 3 is back")


def _stop_button(stage: SceneStage) -> None:
    stage.tell(keys.MOVE, distance=1.0)
    stage.ask("fault", fault="stop-pressed@0.5+3")
    state = stage.see(keys.STATE, lambda state: state.estop, "the pressed button")
    stage.say("; ".join(state.faults))
    stage.say(f"a command meanwhile: {stage.is_refused(keys.MOVE, distance=1.0)}")
    stage.see(keys.STATE, lambda state: not any("STOP" in fault for fault in state.faults), "the button out again")
    stage.tell(keys.ENABLE, on=True)
    stage.say("the button is out and the motors are on again")


def _gyro(stage: SceneStage) -> None:
    stage.see(keys.IMU, what="turn rates")
    stage.ask("fault", fault="gyro-failed@0+4")
    state = stage.see(keys.STATE, lambda state: any("gyro" in fault for fault in state.faults), "a failed gyro")
    stage.say("; ".join(state.faults))
    stage.see(keys.STATE, lambda state: not any("gyro" in fault for fault in state.faults), "the gyro back")
    stage.see(keys.IMU, what="turn rates again")
    stage.say("the gyro is back")


SCENES = (
    Scene("wheel-stalled", "something blocks a wheel", "--robot p3dx-sh:{name}", _stalled),
    Scene("sonar-dead", "a sonar disc goes deaf", "--robot p3dx-sh:{name} --perfect --world office", _dead_disc),
    Scene("stop-pressed", "someone presses the red button", "--robot p3dx-sh:{name}", _stop_button),
    Scene("gyro-failed", "the gyro fails for 4 s", "--robot p3dx-sh:{name} --fit gyro", _gyro),
)
