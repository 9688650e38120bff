import io
import json
import threading

import pytest

from acromovi.topics import Tally, listen, show
from bus import MemoryBus, MemoryNetwork, Sample


def test_the_rate_comes_from_the_first_and_last_arrival() -> None:
    tally = Tally()
    for number in range(31):
        tally.add(Sample("happy/odom", b"", "application/cdr;nav_msgs/msg/Odometry"), 5.0 + number / 10)
    tally.add(Sample("happy/battery", b"", ""), 5.0)
    tally.add(Sample("mine", b"", "zenoh/bytes"), 5.0)
    assert tally.rows() == [
        {"key": "happy/battery", "type": "sensor_msgs/msg/BatteryState", "rate": 0.0, "count": 1},
        {"key": "happy/odom", "type": "nav_msgs/msg/Odometry", "rate": pytest.approx(10.0), "count": 31},
        {"key": "mine", "type": "zenoh/bytes", "rate": 0.0, "count": 1},
    ]


def test_robots_are_listed_without_traffic_and_traffic_without_robots() -> None:
    network = MemoryNetwork()
    robot = MemoryBus(network)
    robot.declare_alive("happy/alive")
    robot.declare_alive("grumpy/alive")
    stop = threading.Event()

    def talk() -> None:
        while not stop.wait(0.005):
            robot.put("strange/lease/state", {})

    talking = threading.Thread(target=talk)
    talking.start()
    report = listen(MemoryBus(network), 0.1)
    stop.set()
    talking.join()
    assert report["robots"] == ["grumpy", "happy"]
    assert [(row["key"], row["type"]) for row in report["topics"]] == [("strange/lease/state", "application/json")]


def test_the_list_is_printed_for_people_and_for_programs() -> None:
    rows = [
        {"key": "happy/odom", "type": "nav_msgs/msg/Odometry", "rate": 10.02, "count": 31},
        {"key": "happy/state", "type": "acromovi_msgs/msg/RobotState", "rate": 0.0, "count": 1},
    ]
    report = {"robots": ["happy"], "topics": rows}
    people, programs = io.StringIO(), io.StringIO()
    show(report, False, people)
    show(report, True, programs)
    assert people.getvalue().splitlines() == [
        "robots: happy",
        "happy/odom   nav_msgs/msg/Odometry           10.0 Hz",
        "happy/state  acromovi_msgs/msg/RobotState   1 in all",
    ]
    assert json.loads(programs.getvalue()) == report


def test_an_empty_bus_says_how_to_start_a_robot() -> None:
    output = io.StringIO()
    show({"robots": [], "topics": []}, False, output)
    assert output.getvalue() == "robots: none; start one with p2os-gateway PORT\nnothing flows\n"
