"""The agent of an arm, on any cable: it moves joints and the tip of the gripper, homes and parks."""

import asyncio
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from agents.components.arm_kinematics import ArmKinematics
from agents.components.component import known
from agents.components.hand_direction import ReachError
from agents.components.motions import MotionGoal, Phase
from agents.components.moving import MovingElementAgent, Result
from agents.platform import on, request
from bus import Refused, keys
from bus.keys import frame
from bus.messages import NS_PER_S, Arm, JointState, stamp_ns

TOLERANCES = {"rad": 0.02, "m": 0.002}
"""More than a count of any servo."""
LONGEST = 60.0
"""Seconds for any motion but a slow one."""
SPARE = 10.0
"""Seconds beyond what the whole way of the longest joint takes at the speed that was asked for."""
SETTLING = 3.5
"""Seconds before servos whose power was just switched on begin to move."""
PAUSE = 1.5
"""Seconds that an arm stands at home before its power goes off."""
STOPPING_TIME = 5.0
MOST_WAITING = 8
"""Of `joint_states`, which the arm shares with the gripper and the wheels."""


class ArmAgent(MovingElementAgent):
    """`arm@happy`. Joints are called "1", "2" and so on, from the base; a gripper's is the last, and counts in m."""

    orders = keys.REACH
    results: ClassVar[Mapping[str, str]] = {
        "joints": 'rad by joint, {"1": 0.5}; m of a gripper',
        "powered": "its joints can move",
        "homed": "every joint has found its zero",
        "moving": "some joint moves",
    }

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._arm: Arm | None = None  # until its joints have come
        self._joints: JointState | None = None  # until the arm's message has come
        self._is_powered = True

    @on("arm")
    async def _hear_arm(self, arm: Arm) -> None:
        self._arm = arm
        self._join()

    @on("joint_states", keep=MOST_WAITING)
    async def _hear_joints(self, joints: JointState) -> None:
        if joints.name and joints.name[0].startswith(frame(self.robot, "arm_joint_")):
            self._joints = joints
            self._join()

    def _join(self) -> None:
        """Make a result of two messages that belong together."""
        arm, joints = self._arm, self._joints
        if arm is None or joints is None or stamp_ns(arm.header) != stamp_ns(joints.header):
            return
        self._is_powered = bool(arm.powered)
        places = zip(joints.name, joints.position.tolist(), strict=True)
        self.renew(
            {
                "stamp": stamp_ns(arm.header) / NS_PER_S,
                "joints": {name.rpartition("_")[2]: known(place) for name, place in places},
                "powered": self._is_powered,
                "homed": bool(arm.homed),
                "moving": any(arm.moving),
            }
        )

    def reasons(self) -> str:
        """Return the known reasons for a failure; first of all a lack of power."""
        reasons = super().reasons()
        return reasons if self._is_powered else "; ".join(filter(None, ("the arm has no power", reasons)))

    @request("move", agrees_itself=True)
    async def move_joints(
        self, joints: dict[str, Any], speed: float | None = None, wait: bool = True, token: str = ""
    ) -> dict[str, Any]:
        """Send joints to places, {"1": 0.5}: rad, m of a gripper; at a speed in rad/s, or their usual one."""
        parts = tuple(map(str, joints)) if isinstance(joints, dict) else ()  # the gateway refuses invalid values
        goal = MotionGoal(
            f"{self.element} move", parts, self._arriving(joints), self._time_at(speed), time_to_start=SETTLING
        )
        return await self.carry_out(goal, token, wait, do="move", joints=joints, speed=speed)

    @request("reach", agrees_itself=True)
    async def reach(
        self,
        x: float,
        y: float,
        z: float,
        speed: float | None = None,
        pitch: float | None = None,
        yaw: float | None = None,
        wait: bool = True,
        token: str = "",
    ) -> dict[str, Any]:
        """Bring the tip of the gripper to a point, m in base_link; the hand points `pitch` rad below level.

        The direction of the hand is free without a pitch, and away from the arm's base without a yaw, rad to the left.
        With a pitch, the fingers part level. They stay as they are. The result has the point as `tip`, by the joints as
        they are reported.
        """
        kinematics = self._kinematics
        if kinematics is None:
            raise Refused("the lengths of the arm are not known; send its joints by move")
        present = self._angles(await self.read())
        search = kinematics.reaching((x, y, z), present, pitch, yaw)
        try:
            while True:
                next(search)
                await asyncio.sleep(0.0)  # the other agents of the container go on meanwhile
        except StopIteration as end:
            angles = end.value
        except ReachError as err:
            raise Refused(str(err)) from err
        joints = {str(number): float(angle) for number, angle in enumerate(angles, 1)}
        result = await self.move_joints(joints, speed, wait, token)
        tip = kinematics.forward(self._angles(result))
        return {**result, "tip": [float(each) for each in tip]}

    @request("home", agrees_itself=True)
    async def go_home(self, wait: bool = True, token: str = "") -> dict[str, Any]:
        """Send every joint home."""
        arriving = self._arriving({name: row["home"] for name, row in self._rows.items() if "home" in row})

        def judge(result: Result) -> Phase:
            phase = arriving(result)
            return Phase.RESTING if phase is Phase.ARRIVED and not result["homed"] else phase

        goal = MotionGoal(f"{self.element} home", self._every_joint, judge, LONGEST, time_to_start=SETTLING)
        return await self.carry_out(goal, token, wait, do="home")

    @request("park", agrees_itself=True)
    async def park(self, wait: bool = True, token: str = "") -> dict[str, Any]:
        """Send every joint home, and switch its power off there."""
        return await self._switch(False, f"{self.element} park", wait, token, do="park")

    @request("power", agrees_itself=True)
    async def switch_power(self, on: bool, wait: bool = True, token: str = "") -> dict[str, Any]:
        """Switch the power, or what halts the joints; off sends a Pioneer's arm home first."""
        what = f"{self.element} power {'on' if on else 'off'}"
        return await self._switch(on, what, wait, token, do="power", on=on)

    @request("stop", agrees_itself=True)
    async def stop(self, token: str = "") -> dict[str, Any]:
        """Stop every joint where it is."""
        goal = MotionGoal(f"{self.element} stop", self._every_joint, _is_still, STOPPING_TIME)
        return await self.carry_out(goal, token, do="stop")

    async def _switch(self, powered: bool, what: str, wait: bool, token: str, **order: Any) -> dict[str, Any]:
        def judge(result: Result) -> Phase:
            if result["moving"]:
                return Phase.MOVING
            return Phase.ARRIVED if result["powered"] is powered else Phase.RESTING

        goal = MotionGoal(what, self._every_joint, judge, LONGEST, time_to_start=SETTLING, pause=PAUSE)
        return await self.carry_out(goal, token, wait, **order)

    @classmethod
    def properties_of(cls, robot: Mapping[str, Any], element: Mapping[str, Any]) -> dict[str, Any]:
        """Return the properties, with the hull that carries the arm."""
        return {**super().properties_of(robot, element), "hull": robot["geometry"]}

    @property
    def _kinematics(self) -> ArmKinematics | None:
        return ArmKinematics.of(self.properties)

    def _angles(self, result: Result) -> list[float]:
        """Return the angles of the turning joints.

        Raises:
            Refused: One of them is not known.
        """
        turning = [name for name, row in self._rows.items() if row["unit"] == "rad"]
        angles = [result["joints"].get(name) for name in turning]
        if any(angle is None for angle in angles):
            raise Refused('the arm does not know where its joints are; send arm {"do": "home"}')
        return [float(angle) for angle in angles if angle is not None]

    @property
    def _rows(self) -> dict[str, Mapping[str, Any]]:
        """Return the joints of the description."""
        return {row["name"].rpartition("_")[2]: row for row in self.properties.get("joints", [])}

    @property
    def _every_joint(self) -> tuple[str, ...]:
        return ("every", *self._rows)

    def _time_at(self, speed: float | None) -> float:
        """Return the longest time for any motion, s, at a speed in rad/s or the joints' usual one."""
        ways = [row["upper"] - row["lower"] for row in self._rows.values() if row["unit"] == "rad"]
        is_slow = isinstance(speed, float | int) and speed > 0 and bool(ways)
        return max(LONGEST, SPARE + max(ways) / speed) if is_slow else LONGEST

    def _arriving(self, joints: Mapping[str, float]) -> Callable[[Result], Phase]:
        """Whether joints are at these places. The gateway has said that they can be there."""
        rows = self._rows

        def judge(result: Result) -> Phase:
            if result["moving"]:
                return Phase.MOVING
            places = {str(int(name)): place for name, place in joints.items()}
            are_there = all(
                abs(result["joints"][name] - place) <= TOLERANCES[rows[name]["unit"] if name in rows else "rad"]
                for name, place in places.items()
            )
            return Phase.ARRIVED if are_there else Phase.RESTING

        return judge


def _is_still(result: Result) -> Phase:
    return Phase.MOVING if result["moving"] else Phase.ARRIVED
