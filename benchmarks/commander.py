"""An application reduced to its stream: commands a robot to drive straight on, ten times a second, until it is ended.

`python -m benchmarks.commander ROBOT SPEED PROFILE`; it prints a line once the first command is out.
"""

import sys
import time

from bus import ZenohBus, keys
from bus.messages import twist

PERIOD_S = 0.1


def main(robot: str, speed: float, profile: str) -> None:
    """Drive at `speed`, m/s, over the bus profile."""
    with ZenohBus.open(profile) as bus, bus.publisher(keys.CMD_VEL.key(robot), keys.CMD_VEL.type_name) as velocity:
        velocity.put(twist(speed, 0.0))
        print("driving", flush=True)
        while True:
            time.sleep(PERIOD_S)
            velocity.put(twist(speed, 0.0))


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), sys.argv[3])
