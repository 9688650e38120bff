"""What the physics engine has to compute: what something may touch, and what moves by itself."""

from collections.abc import Callable, Iterator, Mapping

from geometry import Polygon
from p2os_emu.world.bystanders import Bystanders
from p2os_emu.world.engine import STEP
from p2os_emu.world.moving_doors import LEAF_THICKNESS
from p2os_emu.world.nearness import PERIOD, Circle, NearnessWatch
from p2os_emu.world.objects import Objects
from p2os_emu.world.people import BODY_RADIUS, MOST_SPEED
from p2os_emu.world.robot_body import RobotBody
from p2os_emu.world.spec import WorldSpec, rectangle
from p2os_emu.world.still_outlines import StillOutlines

LOOK_PERIOD = round(PERIOD / STEP)
"""Steps from one look at which robots have room to the next."""
MOST_THING_SPEED = 2.0
"""m/s that nothing exceeds that robots push."""


class EngineUse:
    """Shares the robots of one world out between the engine and the models of their wheels.

    is_spared: robots that nothing can touch are computed by the model; otherwise the engine computes all. things_rest:
    no movable object has moved for some time.
    """

    def __init__(
        self, spec: WorldSpec, objects: Objects, bystanders: Bystanders, robots: Mapping[str, RobotBody]
    ) -> None:
        """Let the engine compute everything at first.

        Args:
            spec: Of the world.
            objects: In it.
            bystanders: In it.
            robots: In it, by name; the same object always.
        """
        self.is_spared = True
        self._objects = objects
        self._bystanders = bystanders
        self._robots = robots
        self._room = NearnessWatch(StillOutlines(_still_outlines(spec)))
        self._is_due = True
        self.things_rest = False

    def look_again(self) -> None:
        """Look for room at the next step: a robot has come or was put elsewhere."""
        self._is_due = True

    def share(self, steps: int) -> None:
        """Before a step, if it is time: let the engine compute the robots that something may touch, and no others."""
        if not self.is_spared or not (self._is_due or steps % LOOK_PERIOD == 0):
            return
        self._is_due = False
        robots = {name: robot.circle for name, robot in self._robots.items()}
        things = [Circle(*each, MOST_THING_SPEED) for each in self._objects.circles()]
        people = [Circle(each.x, each.y, BODY_RADIUS, MOST_SPEED) for each in self._bystanders.people().values()]
        with_room = self._room.look(robots, (*things, *people))
        for name, robot in self._robots.items():
            if name not in with_room:
                robot.enter_engine()
            elif robot.is_in_engine:
                robot.leave_engine()

    def step(self, step_engine: Callable[[], None]) -> None:
        """Let the engine take a step if it computes something that moves, or that may be touched."""
        if self._is_needed:
            self.put_robots()  # or others would run into them where they were
            step_engine()
        elif any(robot.senses_by_engine for robot in self._robots.values()):
            self.put_robots()

    def look_at_things(self) -> None:
        """Look once more whether all movable objects are at rest."""
        self.things_rest = self._objects.watch_for_rest()

    def put_robots(self) -> None:
        """Put all robots where they are in the engine too, for those who look there."""
        for robot in self._robots.values():
            robot.put()

    @property
    def _is_needed(self) -> bool:
        if not (self.is_spared and self.things_rest):
            return True
        there = [robot for robot in self._robots.values() if robot.is_in_engine]
        return bool(there and self._bystanders) or any(not robot.is_resting for robot in there)


def _still_outlines(spec: WorldSpec) -> Iterator[Polygon]:
    """Outlines of what does not move, and of where the leaves of doors slide."""
    yield from (block.footprint for block in (*spec.walls, *spec.furniture))
    for door in spec.moving_doors:
        yield rectangle(door.frame, door.width, door.width, LEAF_THICKNESS)
