"""The gyro on the bus."""

from collections.abc import Iterable

import numpy as np

from bus import keys
from bus.keys import Topic, frame
from bus.messages import Imu, Quaternion, Vector3, header
from gateway.driver import Driver
from gateway.elements.adapter import BusAdapter
from gateway.elements.gyro.element import Gyro
from gateway.events import Event, TurnRateSeen
from p2os import RobotModel

FIXED_VARIANCE = 1e-9
"""Of the axes about which a robot in the plane does not turn, (rad/s)²."""


class GyroAdapter(BusAdapter):
    """`<robot>/imu`: the turn rate about the vertical axis; orientation and acceleration are unknown."""

    name = "gyro"
    streams = (keys.IMU,)

    def __init__(self, robot: str, model: RobotModel) -> None:
        super().__init__(robot, model)
        self._unknown = np.array([-1.0, *[0.0] * 8])  # as sensor_msgs/Imu wants what nobody measures
        self._covariance = np.diag([FIXED_VARIANCE, FIXED_VARIANCE, 0.0]).reshape(9)

    def is_present(self, driver: Driver) -> bool:
        """Its readings come as packets."""
        return driver.has(Gyro)

    def messages(self, event: Event, stamp: int) -> Iterable[tuple[Topic, object]]:
        """One with every packet."""
        if isinstance(event, TurnRateSeen):
            self._covariance[8] = event.variance
            message = Imu(
                header=header(stamp, frame(self._robot, "base_link")),
                orientation=Quaternion(x=0.0, y=0.0, z=0.0, w=1.0),
                orientation_covariance=self._unknown,
                angular_velocity=Vector3(x=0.0, y=0.0, z=event.rate),
                angular_velocity_covariance=self._covariance,
                linear_acceleration=Vector3(x=0.0, y=0.0, z=0.0),
                linear_acceleration_covariance=self._unknown,
            )
            yield keys.IMU, message


class InnerGyroAdapter(BusAdapter):
    """A gyro that the controller uses by itself: it makes the odometry better, and nothing comes of it but that."""

    name = "gyro"

    def is_present(self, driver: Driver) -> bool:
        """The robot says that it has one."""
        return driver.lookup(Gyro).is_inside

    def describe(self, driver: Driver) -> dict[str, str]:
        """Where its readings go."""
        return {"used_by": "the robot's controller, for its odometry"}
