"""Follow whatever is in front of a robot that has a laser.

acromovi container workshop --apps examples
acromovi agent start follow@happy follow:Follow --in workshop
"""

import numpy as np

from agents import Agent, on, request
from bus import Refused, keys, messages

CLOSEST, FARTHEST = 0.5, 2.0  # m; what is farther away is not followed
CONE = 0.5  # rad to either side of straight ahead


class Follow(Agent):
    """Keeps a distance from the nearest object ahead, and turns towards it.

    Properties: `distance`, m [0.8]; `speed`, the highest, m/s [0.3].
    """

    services = ("follow",)

    async def setup(self):
        """Read the properties."""
        self.distance = self.properties.get("distance", 0.8)
        self.speed = self.properties.get("speed", 0.3)
        self.scans = 0

    def pack(self):
        """Return the state that moves with the agent to another container."""
        return {"distance": self.distance, "scans": self.scans}

    def unpack(self, state):
        """Restore that state; `setup` has run before."""
        self.distance, self.scans = state["distance"], state["scans"]

    @on("scan")
    async def follow(self, scan):
        """Publish one velocity for each scan; the gateway stops the robot when no velocity comes for 0.5 s."""
        self.scans += 1
        angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
        ranges = np.nan_to_num(scan.ranges, nan=np.inf, posinf=np.inf, neginf=0.0)  # -inf: too close to measure
        ranges[abs(angles) > CONE] = np.inf
        nearest = ranges.argmin()
        if ranges[nearest] < FARTHEST:
            forward = min(max(ranges[nearest] - self.distance, 0.0), self.speed)
            self.bus.put(keys.CMD_VEL.key(self.name.platform), messages.twist(float(forward), float(angles[nearest])))

    @request("keep")
    async def keep(self, distance: float):
        """Keep another distance, m."""
        if not CLOSEST <= distance <= FARTHEST:
            raise Refused(f"cannot keep {distance:g} m; give {CLOSEST:g} to {FARTHEST:g} m")
        self.distance = distance

    @request("status")
    async def status(self):
        """Return the distance, m, and the number of scans since the start."""
        return {"distance": self.distance, "scans": self.scans}
