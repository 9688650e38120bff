"""Pages without a browser read the updates of the map as the console makes them."""

import numpy as np

from apps.console.map_layers import robot_record
from apps.web.viewer import framed
from benchmarks.headless_pages import stamps_of
from tests.recorder.recordings import START, odometry


def test_the_stamps_of_all_robots_are_read_whatever_follows_their_poses() -> None:
    sonar, beams = np.zeros(3, np.uint16), np.zeros(181, np.uint16)
    first = robot_record(1, odometry("happy", 1.0, START), 17.25, sonar, beams)
    second = robot_record(0, odometry("doc", 2.0, START), 18.5, sonar[:0], beams[:0])
    head = {"names": ["doc", "happy"], "live": len(first + second)}
    assert stamps_of(framed(head, first + second + b"cells")) == {"happy": 17.25, "doc": 18.5}
    assert stamps_of(framed({"names": [], "live": 0}, b"")) == {}
