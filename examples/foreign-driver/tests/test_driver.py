"""The driver on emulated robots. Acromovi's pytest plugin gives them; nothing needs to be imported."""

import pytest
from pioneer_driver import DriverError, PioneerDriver

SPEED = 0.2  # m/s


@pytest.mark.emulated_robot("p3dx-sh:happy")
def test_driver_meets_the_robot_by_name(emulated_robot):
    with PioneerDriver(emulated_robot.port) as driver:
        emulated_robot.wait_until_connected()
        assert driver.name == "happy"
    emulated_robot.wait_until(lambda truth: not truth.connected, what="the driver let the robot go")


@pytest.mark.parametrize("link", ["ideal", "rs232"])
def test_robot_moves_half_a_metre_and_knows_it(emulate_robots, link):
    (robot,) = emulate_robots("p3dx-sh", link=link)
    with PioneerDriver(robot.port) as driver:
        driver.wait_until(lambda: driver.report.motors_enabled)
        driver.move(0.5)
        robot.wait_until_it_moves()
        truth = robot.wait_until_it_stands()
        assert truth.x == pytest.approx(0.5, abs=0.03)
        driver.wait_until(lambda: abs(driver.report.x - truth.x) < 0.03)


@pytest.mark.emulated_robot("p3dx-sh")
def test_driver_survives_a_cut_line_and_the_robot_does_not_start_by_itself(emulated_robot):
    with PioneerDriver(emulated_robot.port) as driver:
        driver.wait_until(lambda: driver.report.motors_enabled)
        driver.drive(SPEED)
        emulated_robot.wait_until(lambda truth: truth.linear > 0.9 * SPEED, what="it drove")
        cut = emulated_robot.fault("line-cut")
        stopped = emulated_robot.wait_until_it_stands()  # by its own watchdog
        with pytest.raises(DriverError, match="not connected"):
            driver.drive(SPEED)
        cut.clear()
        driver.wait_until(lambda: driver.report.motors_enabled)
        assert driver.lost == 1
        assert emulated_robot.wait_until_it_stands().x == pytest.approx(stopped.x, abs=0.01)
        driver.drive(SPEED)
        emulated_robot.wait_until(lambda truth: truth.linear > 0.9 * SPEED, what="it drove again")


@pytest.mark.emulated_robot("p3dx-sh")
def test_robot_stops_when_somebody_presses_stop_and_drives_only_once_enabled(emulated_robot):
    with PioneerDriver(emulated_robot.port) as driver:
        driver.wait_until(lambda: driver.report.motors_enabled)
        driver.drive(SPEED)
        emulated_robot.wait_until(lambda truth: truth.linear > 0.9 * SPEED, what="it drove")
        button = emulated_robot.fault("stop-pressed")
        emulated_robot.wait_until_it_stands()
        driver.wait_until(lambda: driver.report.stop_pressed)
        button.clear()
        driver.wait_until(lambda: not driver.report.stop_pressed)
        with pytest.raises(DriverError, match="the motors are off"):
            driver.drive(SPEED)
        driver.enable()
        driver.wait_until(lambda: driver.report.motors_enabled)
        driver.drive(SPEED)
        emulated_robot.wait_until(lambda truth: truth.linear > 0.9 * SPEED, what="it drove again")


@pytest.mark.emulated_robot("p3dx-sh", faults=["line-noisy:rate=0.0005"], seed=3)
def test_noise_on_the_line_does_not_stop_the_driver(emulated_robot):
    with PioneerDriver(emulated_robot.port) as driver:
        driver.wait_until(lambda: driver.report.motors_enabled)
        driver.drive(SPEED)
        emulated_robot.wait_until(lambda truth: truth.x > 0.3, what="it drove 0.3 m")
        assert driver.lost == 0
