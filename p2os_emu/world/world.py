"""The world: a floor, walls, furniture and robots under one physics engine, stepped by count and never by the clock."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from math import isfinite
from random import Random
from types import MappingProxyType

import numpy as np

from geometry import Pose2D
from p2os.robot_model import RobotModel
from p2os_emu.fit import BARE, Fit
from p2os_emu.gripper_model import gripper_of
from p2os_emu.surroundings import Touches, Truth
from p2os_emu.target_model import target_of
from p2os_emu.world import window
from p2os_emu.world.bystanders import Bystanders
from p2os_emu.world.chassis import HULL_BOTTOM, HULL_TOP, Chassis, Imperfections
from p2os_emu.world.collision import HULL, build_blocks, build_floor
from p2os_emu.world.engine import STEP, PhysicsClient, engine
from p2os_emu.world.engine_use import EngineUse
from p2os_emu.world.errors import WorldError
from p2os_emu.world.leaves import DoorState
from p2os_emu.world.light import LightCourse, LightState
from p2os_emu.world.look import Look, floor_look, furniture_look, movable_look, robot_looks, wall_look
from p2os_emu.world.objects import MovingObject, ObjectPlace, Objects
from p2os_emu.world.physics import open_physics, solve_chains
from p2os_emu.world.placement import Obstacles, free_pose, overlapping
from p2os_emu.world.planar import PlanarScene
from p2os_emu.world.presence import Footprint
from p2os_emu.world.robot_body import RobotBody
from p2os_emu.world.sight import Sight
from p2os_emu.world.sonar import HEIGHT, SonarRays, level_fan
from p2os_emu.world.sonar_scene import Solid, SonarScene
from p2os_emu.world.spec import Block, WorldSpec
from p2os_emu.world.stepping_aside import Asker
from p2os_emu.world.textures import choose_texture
from p2os_emu.world.touches import TouchLog
from p2os_emu.world.walkers import PersonPlace, check_routes

LOOK_AT_PARKED = 12
"""Steps from one thorough look at robots that rest, or may rest, to the next."""


class World:
    """Physics for any number of robots.

    The same spec, seed and calls give bit-identical states, and each World is apart from all others in the process.

    rest_parked: robots that are parked are not computed until they are driven or touched. While all of them are, and
    nothing else moves, the engine computes nothing. engine_use: what the engine computes of the rest.
    sonar_in_plane: level rays of sonar are cast by arithmetic where that suffices, not by the engine.
    """

    def __init__(self, spec: WorldSpec, *, seed: int = 0, perfect: bool = False, gui: bool = False) -> None:
        """Build a world.

        Args:
            spec: What stands where.
            seed: Of every imperfection; each robot draws its own from seed and name.
            perfect: No imperfections: exact wheels, exact track, sonar without noise, misses or cross-talk.
            gui: Show a window.
        Raises:
            WorldError: Somebody's route leads through a wall, there is no display for the window, or the engine has no
                room for one more world.
        """
        check_routes(spec)
        self.spec = spec
        self.steps = 0
        self._seed = seed
        self._perfect = perfect
        self._obstacles = Obstacles((*spec.walls, *spec.furniture, *spec.drops))
        self._has_overhangs = any(block.bottom > 0.0 for block in (*spec.walls, *spec.furniture))
        self._robots: dict[str, RobotBody] = {}
        self.rest_parked = True
        self._is_still = False  # nothing moves, and nothing will until a robot wakes up
        self._moving: tuple[MovingObject, ...] | None = None
        self._has_window = gui
        self._client = open_physics(gui)
        self._floor_id = build_floor(self._client)
        walls = build_blocks(self._client, spec.walls)
        furniture = build_blocks(self._client, spec.furniture)
        self.objects = Objects(self._client, spec.objects)
        self._bystanders = Bystanders(self._client, spec, seed)
        self._touches: dict[str, TouchLog] = {}
        self._placed: dict[str, int] = {}
        self._names = _names(walls, spec.walls, "a wall") | _names(furniture, spec.furniture, "furniture")
        self._names |= {body: movable.name for body, movable in self.objects.bodies.items()} | self._bystanders.names
        self.engine_use = EngineUse(spec, self.objects, self._bystanders, self._robots)
        self.engine_use.is_spared = not gui  # a window shows what the engine computes
        self._scene = PlanarScene((*spec.walls, *spec.furniture), lambda: self.moving)
        blocks = (*spec.walls, *spec.furniture)
        self._heard = SonarScene(self._client, HEIGHT, level_fan(), blocks, lambda: self.steps)
        self._light = None if spec.light is None else LightCourse(spec.light, seed)
        self.sight = Sight(self._client, lambda: self.light, self.engine_use.put_robots)
        if gui:
            window.arrange(self._client, spec)
        self.sight.add(self._floor_id, {HULL: floor_look(spec)}, is_fixed=True)
        textures = spec.textures
        for number, (body, wall) in enumerate(zip(walls, spec.walls, strict=True)):
            texture = choose_texture(textures.walls, wall.colour, f"{seed} wall {number}")
            self._show(body, {HULL: wall_look(wall, texture)}, is_fixed=True)
        for number, (body, piece) in enumerate(zip(furniture, spec.furniture, strict=True)):
            texture = choose_texture(textures.furniture, piece.colour, f"{seed} furniture {number}")
            self._show(body, {HULL: furniture_look(piece, texture)}, is_fixed=True)
        for body, movable in self.objects.bodies.items():
            self._show(body, {HULL: movable_look(movable)})
            self._heard.add(body, Solid.movable(movable))
        for body, look in self._bystanders.looks.items():
            self._show(body, {HULL: look})
        for body, bystander in self._bystanders.bodies.items():
            self._heard.add(body, Solid.bystander(bystander))

    @property
    def time(self) -> float:
        """Simulated time since the world began, s."""
        return self.steps * STEP

    @property
    def sonar_in_plane(self) -> bool:
        """Whether level rays of sonar are cast by arithmetic."""
        return self._heard.is_used

    @sonar_in_plane.setter
    def sonar_in_plane(self, on: bool) -> None:
        self._heard.is_used = on

    @property
    def light(self) -> LightState | None:
        """The light now; None in a world where it never changes."""
        return None if self._light is None else self._light.at(self.time)

    @property
    def robots(self) -> tuple[str, ...]:
        """Names of the robots in the world, first come first."""
        return tuple(self._robots)

    @property
    def moving(self) -> Sequence[MovingObject]:
        """Everything that may be elsewhere after the next step, where it is now: objects, robots, doors, people."""
        if self._moving is None:
            robots = (
                MovingObject(name, robot.chassis.hull(robot.pose), HULL_BOTTOM, robot.chassis.height)
                for name, robot in self._robots.items()
            )
            self._moving = (*self.objects.moving(), *robots, *self._bystanders.moving())
        return self._moving

    def add_robot(self, name: str, model: RobotModel, pose: Pose2D | None = None, fit: Fit = BARE) -> RobotBody:
        """Put a robot into the world, at rest and without power.

        Args:
            name: Unique in this world.
            model: What it is.
            pose: Where its axle is; without it, the first free place of the world.
            fit: Its accessories.
        Raises:
            WorldError: The name is taken, the place is not free, or no place is.
        """
        if name in self._robots:
            raise WorldError(f"there is a robot {name!r} already; give this one another name")
        random = None if self._perfect else Random(f"{self._seed} {name}")
        imperfections = Imperfections() if random is None else Imperfections.drawn(random)
        gripper = gripper_of(fit)
        # Where everything stands on the floor, the hull touches all that a column on it could touch.
        height = model.height if self._has_overhangs else HULL_TOP
        chassis = Chassis.of(model, imperfections, gripper.reach if gripper else 0.0, height)
        if pose is None:
            pose = self._free_pose(name, chassis)
        else:
            self._check_free(name, chassis, pose)
        robot = RobotBody(
            self._client,
            self._floor_id,
            model,
            chassis,
            SonarRays(model.sonar, random, self._heard, has_overhangs=self._has_overhangs),
            pose,
            fit,
            self.objects,
            self.spec.drops,
            self.spec.magnets,
            name,
            self._scene,
            None if random is None else np.random.default_rng(Random(f"{self._seed} {name} scan").getrandbits(64)),
            self.spec.docks,
            self.engine_use.put_robots,
        )
        if fit.has("arm"):
            solve_chains(self._client)
        self._robots[name] = robot
        self._names[robot.body_id] = name
        solid = None if any(link.collides for link in robot.links) else Solid.robot(chassis)
        self._heard.add(robot.body_id, solid, lambda: None if robot.is_in_engine else robot.pose)
        self._touches[name] = TouchLog()
        self._placed[name] = 0
        self._moving = None
        self.engine_use.look_again()
        self._set_still(False)
        self._show(robot.body_id, robot_looks(name, chassis, robot.links, target_of(fit)))
        return robot

    def remove_robot(self, name: str) -> None:
        """Take a robot out of the world.

        Raises:
            WorldError: There is no such robot.
        """
        robot = self._robot(name)
        robot.lift()
        self.sight.remove(robot.body_id)
        self._heard.remove(robot.body_id)
        self._client.removeBody(robot.body_id)
        del self._robots[name], self._names[robot.body_id], self._touches[name], self._placed[name]
        self._moving = None
        self._set_still(False)

    def step(self) -> None:
        """Let `STEP` seconds pass."""
        rests = all(robot.is_resting for robot in self._robots.values())
        if rests and self._is_still:
            self.steps += 1
            return
        self.engine_use.share(self.steps)
        if self._bystanders:
            self._bystanders.step(
                lambda: (Footprint.of(robot.chassis.footprint(robot.pose)) for robot in self._robots.values()),
                lambda: (Footprint.of(thing.footprint) for thing in self.objects.moving()),
            )
        self.engine_use.step(self._client.stepSimulation)
        self.steps += 1
        self._moving = None
        is_look_due = self.steps % LOOK_AT_PARKED == 0
        if is_look_due:
            self.engine_use.look_at_things()
        for name, robot in self._robots.items():
            if robot.is_resting:
                robot.notice(thoroughly=is_look_due)
            else:
                robot.step()
                if is_look_due and self.rest_parked:
                    robot.rest_if_parked()
            if robot.touched:
                self._touches[name].note(self.time, {self._names[body] for body in robot.touched})
        # Not before the engine has put to sleep whoever has just been parked: it takes a step to wake them.
        self._set_still(is_look_due and rests and self._stands_still())

    def truth(self, name: str) -> Truth:
        """Where a robot truly is.

        Raises:
            WorldError: There is no such robot.
        """
        robot = self._robot(name)
        return Truth(robot.pose, *robot.velocity)

    def object_places(self) -> Mapping[str, ObjectPlace]:
        """Where each movable object is."""
        return self.objects.places()

    def held(self, name: str) -> str | None:
        """Return the name of the object that a robot's gripper or arm holds; None where it holds none.

        Raises:
            WorldError: There is no such robot.
        """
        return self._robot(name).held

    def placed(self, name: str) -> int:
        """How often a robot has been put somewhere else since it was added."""
        return self._placed[name]

    def touches(self, name: str) -> Touches:
        """What a robot has bumped into, with its hull or an accessory.

        Raises:
            WorldError: There is no such robot.
        """
        self._robot(name)
        return self._touches[name].touches

    def sound(self, name: str) -> None:
        """Let people hear a sound of a robot; who is near ahead of it lets it pass.

        Raises:
            WorldError: There is no such robot.
        """
        robot = self._robot(name)

        def asker() -> Asker | None:
            if self._robots.get(name) is not robot:
                return None
            return Asker(robot.pose, robot.chassis.width, robot.chassis.sweep)

        self._bystanders.hear(asker)

    def people(self) -> Mapping[str, PersonPlace]:
        """Where everybody is who walks about."""
        return self._bystanders.people()

    def stop_people(self, on: bool) -> None:
        """Stop the people, or let them walk again."""
        self._bystanders.stop_people(on)

    def doors(self) -> Mapping[str, DoorState]:
        """How far each door with a leaf is open."""
        return self._bystanders.doors()

    def set_door(self, name: str, is_open: bool) -> None:
        """Open or shut a door; from then on it does no more by itself.

        Raises:
            WorldError: There is no such door.
        """
        self._bystanders.set_door(name, is_open)

    def place(self, name: str, pose: Pose2D) -> None:
        """Lift a robot and put it down at rest somewhere else; its encoders do not notice.

        Raises:
            WorldError: There is no such robot, or the place is not free.
        """
        self.place_all({name: pose})

    def place_all(self, poses: Mapping[str, Pose2D]) -> None:
        """Lift robots, and put them down at rest when all are in the air, so that they may change places.

        Raises:
            WorldError: There is no such robot, or a place is not free; none is lifted then.
        """
        for name, pose in poses.items():
            self._check_free(name, self._robot(name).chassis, pose, poses)
        for name, pose in poses.items():
            self._robot(name).move_to(pose)
            self._placed[name] += 1
        self.engine_use.look_again()
        self._heard.forget_places()
        self._moving = None
        self._set_still(False)

    def close(self) -> None:
        """End the world; no robot of it can be used any more. Closing twice does nothing."""
        if self._client.number >= 0:
            if self._client.isConnected():
                self._client.disconnect()
            self._client = PhysicsClient(-1)
            self._robots.clear()

    @contextmanager
    def until_window_closes(self) -> Iterator[None]:
        """Step the world inside this block: whoever closes its window ends the block, and that is no error."""
        try:
            yield
        except engine.error:
            if self._client.isConnected():
                raise

    def _show(self, body: int, looks: Mapping[int, Look], *, is_fixed: bool = False) -> None:
        self.sight.add(body, looks, is_fixed=is_fixed)
        if self._has_window:
            window.paint(self._client, body, looks)

    def __enter__(self) -> "World":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _set_still(self, on: bool) -> None:
        if on != self._is_still:
            self._is_still = on
            for robot in self._robots.values():
                robot.keep_echoes(on)

    def _stands_still(self) -> bool:
        """Tell whether nothing can move before a robot wakes up; in a window, the mouse moves things."""
        if self._bystanders or self._has_window or not all(robot.is_resting for robot in self._robots.values()):
            return False
        return self.engine_use.things_rest

    def _robot(self, name: str) -> RobotBody:
        try:
            return self._robots[name]
        except KeyError:
            there = ", ".join(self._robots) or "none"
            raise WorldError(f"there is no robot {name!r} in this world; there are: {there}") from None

    def _free_pose(self, name: str, chassis: Chassis) -> Pose2D:
        others = [(pose.x, pose.y, robot.chassis.sweep) for robot in self._robots.values() for pose in (robot.pose,)]
        others += self.objects.circles()
        others += [(each.x, each.y, each.reach) for each in self._bystanders.presences().values()]
        pose = free_pose(self.spec.starts, self._obstacles, others, chassis.sweep, chassis.height)
        if pose is None:
            raise WorldError(f"world {self.spec.name!r} has no free place left for robot {name!r}; give it a pose")
        return pose

    def _check_free(
        self, name: str, chassis: Chassis, pose: Pose2D, poses: Mapping[str, Pose2D] = MappingProxyType({})
    ) -> None:
        """Raise WorldError if a robot cannot stand at a pose, while others stand at poses of their own."""
        if not all(map(isfinite, (pose.x, pose.y, pose.heading))):
            raise WorldError(f"robot {name!r} cannot stand at {pose}: give finite numbers")
        footprint = chassis.footprint(pose)
        others = [
            (f"robot {other!r}", robot.chassis.footprint(poses.get(other, robot.pose)))
            for other, robot in self._robots.items()
            if other != name
        ]
        others += ((thing.name, thing.footprint) for thing in self.objects.moving())
        others += ((someone, presence.outline) for someone, presence in self._bystanders.presences().items())
        in_the_way = self._obstacles.overlapping(footprint, chassis.height) or overlapping(footprint, others)
        if in_the_way:
            raise WorldError(
                f"robot {name!r} cannot stand at ({pose.x:.2f}, {pose.y:.2f}) m: {in_the_way} is in the way"
            )


def _names(bodies: Iterable[int], blocks: Iterable[Block], otherwise: str) -> dict[int, str]:
    return {body: block.name or otherwise for body, block in zip(bodies, blocks, strict=True)}
