"""The gyro on the bus."""

from collections.abc import Iterable
from typing import Never

import numpy as np

from bus import keys
from bus.keys import Topic, frame
from bus.messages import Imu, Quaternion, Vector3, header
from gateway.elements.adapter import BusAdapter, RobotContext
from gateway.elements.gyro.element import Gyro
from gateway.events import TurnRateSeen

FIXED_VARIANCE = 1e-9
"""Of the axes about which a robot in the plane does not turn, (rad/s)²."""


class _GyroAdapter(BusAdapter[TurnRateSeen]):
    """`<robot>/imu`: the turn rate about the vertical axis; orientation and acceleration are unknown."""

    name = "gyro"
    element = Gyro
    streams = (keys.IMU,)
    events = (TurnRateSeen,)

    def __init__(self, robot: RobotContext) -> None:
        super().__init__(robot)
        self._unknown = np.array([-1.0, *[0.0] * 8])  # sensor_msgs/Imu: not measured
        self._covariance = np.diag([FIXED_VARIANCE, FIXED_VARIANCE, 0.0]).reshape(9)

    def messages(self, event: TurnRateSeen, stamp: int) -> Iterable[tuple[Topic, object]]:
        """Return one message for each packet."""
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


class _InnerGyroAdapter(BusAdapter[Never]):
    """A gyro that the controller uses itself: it improves the odometry, and its readings are not published."""

    name = "gyro"

    def is_present(self) -> bool:
        """Return whether the controller reports one."""
        return self._driver.lookup(Gyro).is_inside

    def describe(self) -> dict[str, str]:
        """Return what the readings are used by."""
        return {"used_by": "the robot's controller, for its odometry"}


ADAPTERS = (_GyroAdapter, _InnerGyroAdapter)
