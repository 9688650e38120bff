"""State, faults and diagnostics of the robot, its line and its commands."""

from collections.abc import Mapping, Sequence
from typing import Any

from bus.keys import frame
from bus.messages import DiagnosticArray, DiagnosticStatus, KeyValue, RobotState, header
from gateway.cables.cable import ElementCable, ElementDriver
from gateway.driver import Driver
from p2os import StandardSip


class RobotHealth:
    """Judges one robot, and makes its state and its diagnostics."""

    def __init__(self, name: str, driver: Driver, cables: Sequence[ElementCable]) -> None:
        """Prepare for one robot.

        Args:
            name: Of the robot on the bus.
            driver: Of the robot.
            cables: Elements on cables of their own.
        """
        self._name = name
        self._driver = driver
        self._cables = cables
        self._claims: tuple[str, ...] = ()  # of the latest SIP
        self._judged: tuple[object, ...] = ()  # what they follow from

    def faults(self, sip: StandardSip | None, refusal: str | None) -> list[str]:
        """Return what is wrong, a sentence each.

        Args:
            sip: The last one, None while the robot is not connected.
            refusal: Why a command was just refused.
        """
        driver = self._driver
        found = [] if driver.is_connected else ["the robot is not connected"]
        if driver.link_problem is not None:
            found.append(driver.link_problem.sentence)
        if driver.is_estopped:
            found.append("the e-stop is latched")
        if sip is not None:
            found += self._sip_claims(sip)
            found += driver.faults
        for cable in self._cables:
            found += cable.driver.faults()
        if refusal is not None:
            found.append(refusal)
        return found

    def _sip_claims(self, sip: StandardSip) -> tuple[str, ...]:
        configuration = self._driver.configuration
        judged = sip.stall, sip.flags, sip.fault_flags, sip.best_battery, configuration
        if judged != self._judged:  # one SIP is mostly like the one before
            self._judged = judged
            low = configuration.low_battery if configuration else 0.0
            claims = {
                "the STOP button is pressed": sip.stop_button,
                "the robot's emergency stop is engaged": sip.e_stalled,
                "the left wheel is stalled": sip.left_stalled,
                "the right wheel is stalled": sip.right_stalled,
                "the gyro has failed": sip.gyro_failed,
                f"the battery is low, below {low:.1f} V": sip.best_battery < low,
            }
            self._claims = tuple(claim for claim, is_so in claims.items() if is_so)
        return self._claims

    def state(self, sip: StandardSip | None, found: Sequence[str], stamp: int) -> RobotState:
        """Return the robot's state. found: its faults. stamp: wall clock, ns."""
        driver = self._driver
        flags = sip or StandardSip()
        return RobotState(
            header(stamp, frame(self._name, "base_link")),
            "connected" if driver.is_connected else "connecting" if driver.has_port else "disconnected",
            motors=flags.motors_enabled,
            estop=driver.is_estopped or flags.stop_button or flags.e_stalled,
            sonar=flags.sonar_arrays != 0,
            flags=flags.flags,
            faults=list(found),
        )

    def diagnostics(
        self, found: Sequence[str], refused: Mapping[str, int], unpublished: Mapping[str, int], stamp: int
    ) -> DiagnosticArray:
        """Return the counters since the gateway's start.

        Damaged frames, implausible SIPs, lost links, refused commands, and messages that errors kept from being
        published.

        Args:
            found: The robot's faults.
            refused: Commands refused, counted by what they were.
            unpublished: Messages lost to errors, counted by stream and kind of error.
            stamp: Wall clock, ns.
        """
        name, driver = self._name, self._driver
        robot = name if driver.identity is None else driver.identity.subtype
        level = DiagnosticStatus.OK if not found else DiagnosticStatus.WARN
        status: dict[str, tuple[int, str, Mapping[str, Any]]] = {
            "robot": (
                level if driver.is_connected else DiagnosticStatus.ERROR,
                "; ".join(found) or "all is well",
                {} if driver.link_problem is None else {"cause": driver.link_problem.cause.value},
            ),
            "cable": (
                DiagnosticStatus.OK,
                f"{sum(driver.damaged.values())} damaged frames, {sum(driver.lost.values())} links lost",
                {
                    "baud": driver.baud,
                    **_labelled("damaged", driver.damaged),
                    **_labelled("implausible", driver.implausible),
                    **_labelled("lost", driver.lost),
                },
            ),
            "commands": (DiagnosticStatus.OK, f"{sum(refused.values())} refused", _labelled("refused", refused)),
            "publishers": (
                DiagnosticStatus.WARN if unpublished else DiagnosticStatus.OK,
                f"{sum(unpublished.values())} messages not published because of errors",
                _labelled("error", unpublished),
            ),
            **{cable.name: _element_status(cable.driver) for cable in self._cables},
        }
        return DiagnosticArray(
            header=header(stamp, ""),
            status=[
                DiagnosticStatus(
                    level=severity,
                    name=f"{name}: {part}",
                    message=message,
                    hardware_id=robot,
                    values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
                )
                for part, (severity, message, values) in status.items()
            ],
        )


def _element_status(driver: ElementDriver) -> tuple[int, str, dict[str, Any]]:
    """Return level, message and values of an element on a cable of its own."""
    found = driver.faults()
    level = DiagnosticStatus.WARN if found else DiagnosticStatus.OK
    values = {
        "baud": driver.baud,
        **driver.figures(),
        **_labelled("damaged", driver.damaged),
        **_labelled("lost", driver.lost),
    }
    return level if driver.is_connected else DiagnosticStatus.ERROR, "; ".join(found) or "all is well", values


def _labelled(label: str, counts: Mapping[str, int]) -> dict[str, int]:
    return {f"{label}: {reason}": count for reason, count in sorted(dict(counts).items())}
