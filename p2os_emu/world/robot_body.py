"""One robot in the world: the `Body` that its microcontroller drives."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence

import numpy as np

from configs import load
from geometry import Point, Pose2D
from p2os.accessories.arm_model import ArmModel
from p2os.robot_model import RobotModel
from p2os_emu.body import ArmMechanism, BodyState, Echoes, GripperMechanism, ScanBeams
from p2os_emu.fit import Fit
from p2os_emu.gripper_model import gripper_of
from p2os_emu.world.arm import JointedArm, arm_links
from p2os_emu.world.chassis import Chassis
from p2os_emu.world.collision import HULL, build_robot
from p2os_emu.world.docks import Dock
from p2os_emu.world.drive_train import DriveTrain
from p2os_emu.world.engine import PhysicsClient
from p2os_emu.world.gripper import RobotGripper, gripper_links
from p2os_emu.world.infrared import InfraredRays, sensors_of
from p2os_emu.world.ledges import LedgeModel, Ledges
from p2os_emu.world.links import FIRST, joined
from p2os_emu.world.magnets import Magnet, field_at
from p2os_emu.world.nearness import Circle
from p2os_emu.world.objects import Objects
from p2os_emu.world.planar import PlanarScene
from p2os_emu.world.rays import cast
from p2os_emu.world.sonar import SonarRays
from p2os_emu.world.spec import Block
from p2os_emu.world.touches import Bumper

LINKS_REACH = 1.5
"""m that arm and gripper may reach beyond the hull."""
PARKED_LOOKS = 30
"""Looks at a robot that stands, one in 12 steps, after which it is parked: 3 s.

The engine takes a step to wake it, so robots are not parked in the pauses between the motions of a program.
"""


class RobotBody:
    """Motors, encoders, bumpers and sonar discs of one robot; implements `Body`. Made by `World.add_robot`.

    touched: body ids of what hull and accessories touched in the last step, but for the floor.
    is_resting: it stands, and is not computed until something moves it.
    """

    is_resting = False
    _looks_at_rest = 0
    arm: ArmMechanism | None = None
    _fingers: JointedArm | None = None
    touched: Collection[int] = ()
    _echoes: dict[tuple[int, ...], Sequence[float]] | None = None

    def __init__(
        self,
        client: PhysicsClient,
        floor_id: int,
        model: RobotModel,
        chassis: Chassis,
        sonar: SonarRays,
        pose: Pose2D,
        fit: Fit,
        objects: Objects,
        drops: Sequence[Block],
        magnets: Sequence[Magnet],
        name: str,
        scene: PlanarScene,
        rng: np.random.Generator | None,
        docks: Sequence[Dock],
        put_robots: Callable[[], None],
    ) -> None:
        self._rng = rng
        self._put_robots = put_robots
        self._objects = objects
        self._name = name
        self._scene = scene
        self.model = model
        self.chassis = chassis
        arm = load(ArmModel, "accessories", f"{fit.parts['arm']}-arm") if fit.has("arm") else None
        gripper = gripper_of(fit)
        arm_parts = arm_links(arm) if arm else ()
        gripper_parts = gripper_links(gripper, chassis) if gripper else ()
        self.links = joined([arm_parts, gripper_parts])
        self.body_id = build_robot(client, chassis, pose, self.links)
        self._train = DriveTrain(client, self.body_id, chassis)
        if arm is not None:
            self._fingers = self.arm = JointedArm(client, self.body_id, FIRST, arm, objects, self.wake)
        first = FIRST + len(arm_parts)
        self._gripper = RobotGripper(client, self.body_id, first, gripper, objects, self.wake) if gripper else None
        self._infrared = InfraredRays(client, self.body_id, model, chassis) if sensors_of(model) else None
        ledge = load(LedgeModel, "accessories", "ledge") if fit.has("ledge") else None
        self._ledges = Ledges(client, self.body_id, drops, chassis.front, ledge) if drops else None
        self._magnets = magnets if fit.has("compass") else ()
        self._docks = docks
        self._turns_are_felt = fit.has("gyro") or fit.has("compass")
        self._looks_around = bool(self._turns_are_felt or self._infrared is not None or self._ledges is not None)
        self._client = client
        self._floor_id = floor_id
        self._sonar = sonar
        self._front = Bumper(model.front_bumpers, chassis.front, chassis.width)
        self._rear = Bumper(model.rear_bumpers, chassis.rear, chassis.width)
        # m of rim, as the encoders count it, per rad that the wheel truly turns.
        self._left_rim = chassis.wheel_radius * chassis.imperfections.left_wheel
        self._right_rim = chassis.wheel_radius * chassis.imperfections.right_wheel
        self._strongest = chassis.motor_torque
        self._target: tuple[float, float] | None = (0.0, 0.0)
        self.release()
        self._state = BodyState()

    @property
    def state(self) -> BodyState:
        """The machine after the last physics step."""
        return self._state

    @property
    def gripper(self) -> GripperMechanism | None:
        """The gripper, where one is fitted."""
        return self._gripper

    @property
    def held(self) -> str | None:
        """Name of the object that gripper or arm holds; None where they hold none, or there is neither."""
        held = None if self._gripper is None else self._gripper.held
        if held is None and self._fingers is not None:
            held = self._fingers.held
        return None if held is None else self._objects.bodies[held].name

    @property
    def pose(self) -> Pose2D:
        """Where the middle of the axle truly is, in the world."""
        return self._train.pose

    @property
    def velocity(self) -> tuple[float, float]:
        """True velocity: m/s forward, rad/s counter-clockwise."""
        return self._train.velocity

    @property
    def is_in_engine(self) -> bool:
        """Whether the engine computes it, or would if it did not rest."""
        return self._train.is_in_engine

    @property
    def senses_by_engine(self) -> bool:
        """Whether it looks at others through the engine at each step."""
        return self._infrared is not None or bool(self.links)

    @property
    def circle(self) -> Circle:
        """What it can touch, whichever way it turns."""
        pose, state = self.pose, self._state
        reach = self.chassis.sweep + (LINKS_REACH if self.links else 0.0)
        return Circle(pose.x, pose.y, reach, max(abs(state.left_velocity), abs(state.right_velocity)))

    @property
    def is_docked(self) -> bool:
        """Whether it stands at a dock."""
        return bool(self._docks) and any(dock.reaches(self.pose) for dock in self._docks)

    def drive(self, left: float, right: float) -> None:
        """Command the wheel rims, m/s; the motors follow as far as their torque allows."""
        if self._target != (left, right):
            self._target = left, right
            self.wake()
            self._train.drive(left / self._left_rim, right / self._right_rim, self._strongest)

    def release(self) -> None:
        """Take the power off both motors; gears and brushes bring the wheels to rest."""
        if self._target is not None:
            self._target = None
            self.wake()
            self._train.drive(0.0, 0.0, self.chassis.coasting_torque)

    def ping(self, discs: Sequence[int]) -> list[float]:
        """Fire sonar discs.

        Args:
            discs: Sonar numbers as the robot model counts them (0-based).
        Returns:
            One range per disc, m from the disc's face; `inf` where no echo came back, and for a disc not fitted.
        """
        if self._echoes is None:
            ranges = self._ranges(discs)
        else:
            fired = tuple(discs)
            if fired not in self._echoes:
                self._echoes[fired] = self._ranges(discs)
            ranges = self._echoes[fired]
        return self._sonar.hear(discs, ranges)

    def keep_echoes(self, on: bool) -> None:
        """Let sonar meet what it met before, since nothing moves any more, or cast its rays anew each time."""
        self._echoes = {} if on else None

    def _ranges(self, discs: Sequence[int]) -> Sequence[float]:
        """Ranges of discs before noise and cross-talk, m."""
        pose = self.pose
        ranges = self._sonar.in_plane(discs, pose, self.body_id)
        if ranges is None:
            self._put_robots()
            starts, ends = self._sonar.rays(discs, pose)
            ranges = self._sonar.measure(discs, ends, cast(self._client, starts, ends, self.body_id))
        return ranges

    def scan(self, beams: ScanBeams) -> Echoes:
        """Look along the beams of a planar scanner; its noise comes on top, unless the world is perfect."""
        echoes = self._scene.cast(beams, self.pose, self._name)
        if self._rng is None or not beams.noise:
            return echoes
        disturbed = echoes.ranges + self._rng.normal(0.0, beams.noise, beams.count)
        return echoes._replace(ranges=np.maximum(disturbed, 0.0))

    def rest_if_parked(self) -> None:
        """Stop simulating the robot if it stands in `PARKED_LOOKS` calls, not driven and in touch with nothing."""
        if self._target not in (None, (0.0, 0.0)) or self.held is not None or self.touched or self._train.moves:
            self._looks_at_rest = 0
            return
        self._looks_at_rest += 1
        if self._looks_at_rest >= PARKED_LOOKS:
            self.is_resting = True
            if self.is_in_engine:
                self._train.sleep()

    def wake(self) -> None:
        """Simulate the robot again."""
        self._looks_at_rest = 0
        if self.is_resting:
            self.is_resting = False
            if self.is_in_engine:
                self._train.wake_up()

    def leave_engine(self) -> None:
        """Let a model of the wheels compute the robot, since nothing can touch it; not one that does more than roll."""
        if not (self.links or self._ledges is not None or self.is_resting or self.touched):
            self._train.leave_engine()

    def enter_engine(self) -> None:
        """Let the engine compute the robot again, since something may touch it."""
        self._train.enter_engine(asleep=self.is_resting)

    def put(self) -> None:
        """Put the robot where it is in the engine too, for those who look there."""
        self._train.put()

    def notice(self, *, thoroughly: bool) -> None:
        """Wake a robot that rests if something touches it.

        Args:
            thoroughly: Read the whole machine anew, and wake the robot also if it moves.
        """
        if not self.is_in_engine:
            return
        if thoroughly:
            self.refresh()
        elif self._infrared is not None:
            self._look_around(self.pose)
        if self._touches_anything() or (thoroughly and self._train.moves):
            self.wake()
            self.refresh()

    def move_to(self, pose: Pose2D) -> None:
        """Lift the robot and put it down at rest somewhere else; the encoders do not notice."""
        self.wake()
        self.lift()
        self._train.place(pose)
        self.refresh()

    def lift(self) -> None:
        """Take the robot off whatever it holds and hangs on."""
        if self._gripper is not None:
            self._gripper.let_go()
        if self._fingers is not None:
            self._fingers.let_go()
        if self._ledges is not None:
            self._ledges.free()

    def step(self) -> None:
        """Take the step that the engine has just taken."""
        self._train.advance()
        self.refresh()

    def refresh(self) -> None:
        """Read the machine anew."""
        left, left_speed, left_torque, right, right_speed, right_torque = self._train.wheels
        powered, strongest = self._target is not None, self._strongest
        contacts = self._hull_contacts() if self.is_in_engine else {}
        self.touched = {*contacts, *self._bumped_by_links()} if self.links else contacts
        front, rear = self._bumpers(contacts) if contacts else (0, 0)
        if self._gripper is not None:
            self._gripper.follow()
        if self._fingers is not None:
            self._fingers.follow()
        self._state = BodyState(
            left * self._left_rim,
            right * self._right_rim,
            left_speed * self._left_rim,
            right_speed * self._right_rim,
            min(1.0, abs(left_torque) / strongest) if powered else 0.0,
            min(1.0, abs(right_torque) / strongest) if powered else 0.0,
            front,
            rear,
        )
        if self._looks_around:
            self._look_around(self.pose)

    def _look_around(self, pose: Pose2D) -> None:
        """Add what sensors see and feel that few robots have."""
        if self._turns_are_felt:
            self._state = self._state._replace(heading=pose.heading, turn_rate=self._train.turn_rate)
        if self._magnets:
            self._state = self._state._replace(magnetic=field_at(self._magnets, pose.x, pose.y))
        if self._infrared is not None:
            self._state = self._state._replace(infrared=self._infrared.levels(pose))
        if self._ledges is not None:
            self._ledges.follow(pose)
            far, near = self._ledges.sensed(pose)
            self._state = self._state._replace(far_ledge=far, near_ledge=near)

    def _hull_contacts(self) -> dict[int, list[Point]]:
        """Where the hull touches what, m in the world, by body id; the floor does not count."""
        touched: dict[int, list[Point]] = {}
        for contact in self._client.getContactPoints(bodyA=self.body_id, linkIndexA=HULL):
            other = contact[2]
            if other != self._floor_id and contact[8] <= 0.0:  # their distance
                touched.setdefault(other, []).append(contact[5][:2])
        return touched

    def _bumped_by_links(self) -> Iterator[int]:
        """What arm and gripper touch; things that can be gripped are theirs to touch."""
        for contact in self._client.getContactPoints(bodyA=self.body_id):
            other, link, distance = contact[2], contact[3], contact[8]
            if link >= FIRST and distance <= 0.0 and other not in self._objects:
                yield other

    def _touches_anything(self) -> bool:
        """Tell whether anything but the floor touches hull or accessories, and be it something in the gripper."""
        # Without accessories the engine need not list how the wheels stand on the floor.
        parts = {} if self.links else {"linkIndexA": HULL}
        for contact in self._client.getContactPoints(bodyA=self.body_id, **parts):
            if contact[2] != self._floor_id and contact[8] <= 0.0:
                return True
        return False

    def _bumpers(self, touched: Mapping[int, Sequence[Point]]) -> tuple[int, int]:
        """Pressed segments in front and behind."""
        front = rear = 0
        if self.model.front_bumpers or self.model.rear_bumpers:
            pose = self.pose
            for places in touched.values():
                local = [pose.locate(x, y) for x, y in places]
                front |= self._front.pressed([(x, y) for x, y in local if x >= 0.0])
                rear |= self._rear.pressed([(-x, y) for x, y in local if x < 0.0])
        return front, rear
