"""Infrared sensors that say whether something is near: low ones in front of a PowerBot, a PeopleBot's for table tops.

A sensor looks along one ray, from the hull to the place where clients put what it sees, which is all that is published
of it. Where sensors sit above the floor is assumed.
"""

from collections.abc import Sequence

from geometry import Pose2D
from p2os.robot_model import ACTIVE_LOW, InfraredSensor, RobotModel
from p2os.sip import OPEN_INPUTS
from p2os_emu.world.chassis import HULL_TOP, Chassis
from p2os_emu.world.collision import SEEN_BY_LIGHT
from p2os_emu.world.engine import STEP, PhysicsClient
from p2os_emu.world.rays import Place

PERIOD = round(0.05 / STEP)
"""Steps from one look to the next."""
LOW = 0.1
"""m above the floor, of rays that run level."""
TABLE_TOP = 1.1
"""m above the floor, where rays end that look for table tops."""
FIRST_GENERATION = (
    InfraredSensor(0, ACTIVE_LOW, 1, 0.333, -0.233),
    InfraredSensor(1, ACTIVE_LOW, 1, 0.333, 0.233),
    InfraredSensor(2, ACTIVE_LOW, 1, -0.002, -0.116),
    InfraredSensor(3, ACTIVE_LOW, 1, -0.002, 0.116),
)
"""Of a PeopleBot whose model does not say where its sensors sit: assumed to be as its successors have them."""


def sensors_of(model: RobotModel) -> Sequence[InfraredSensor]:
    """The sensors that a robot has, whether its model says where they sit or not."""
    on_user_inputs = model.table_sensing_ir and not model.new_table_sensing_ir
    return FIRST_GENERATION if on_user_inputs and not model.irs else model.irs


class InfraredRays:
    """The infrared sensors of one robot."""

    def __init__(self, client: PhysicsClient, body: int, model: RobotModel, chassis: Chassis) -> None:
        self._client = client
        self._body = body
        self._sensors = sensors_of(model)
        self._rays = [_ray(sensor, chassis, model.table_sensing_ir) for sensor in self._sensors]
        self._levels = OPEN_INPUTS
        self._wait = 0

    def levels(self, pose: Pose2D) -> int:
        """Bit i is the level of sensor i, as it was when it last looked; to be asked once a step."""
        self._wait -= 1
        if self._wait < 0:
            self._wait = PERIOD - 1
            self._levels = self._look(pose)
        return self._levels

    def _look(self, pose: Pose2D) -> int:
        starts, ends = [], []
        for (x, y, z), (end_x, end_y, end_z) in self._rays:
            starts.append((*pose.transform(x, y), z))
            ends.append((*pose.transform(end_x, end_y), end_z))
        hits = self._client.rayTestBatch(starts, ends, numThreads=1, collisionFilterMask=SEEN_BY_LIGHT)
        levels = OPEN_INPUTS
        for sensor, (body, *_) in zip(self._sensors, hits, strict=True):
            triggered = body >= 0 and body != self._body
            if triggered == (sensor.kind == ACTIVE_LOW):
                levels &= ~(1 << sensor.number)
        return levels


def _ray(sensor: InfraredSensor, chassis: Chassis, seeks_tables: bool) -> tuple[Place, Place]:
    """From the nearest point of the hull to the sensor's place, in `base_link`; straight up over the hull itself."""
    half = chassis.width / 2
    x, y = min(max(sensor.x, -chassis.rear), chassis.front), min(max(sensor.y, -half), half)
    is_above_hull = (x, y) == (sensor.x, sensor.y)
    return (x, y, HULL_TOP if is_above_hull else LOW), (sensor.x, sensor.y, TABLE_TOP if seeks_tables else LOW)
