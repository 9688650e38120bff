"""The application: reads the robot, steps the wanderer, drives, and answers requests."""

import math
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import configs
from agents import Failed, Refused, Robot, RobotError, Stopped, Team, request
from agents.client.element import ElementClient
from apps.background import stop_first
from apps.film import ENDINGS, FilmWriter
from apps.hull import check_hull
from apps.optical_flow.columns import FlowColumns
from apps.optical_flow.feed import FlowFeed
from apps.optical_flow.plots import draw_wandering
from apps.optical_flow.record import FlowRecord
from apps.optical_flow.settings import FlowSettings
from apps.optical_flow.wanderer import Wanderer, WanderOrders
from configs.extras import ExtraMissing, require
from geometry import Point

if TYPE_CHECKING:
    from apps.optical_flow.page import FlowPage  # it needs an extra

SERVICES = ("optical-flow-navigation",)  # for the directory, when it runs as an agent
PLOTS = (".svg", ".png")
_AHEAD = 2.0  # s of the drive that are shown on maps


@dataclass(slots=True)
class _Wandering:
    """What the requests are about."""

    record: FlowRecord | None = None
    orders: WanderOrders | None = None
    settings: FlowSettings = field(default_factory=FlowSettings.load)


_running = _Wandering()


def main(
    team: Team,
    robot: str = "",
    seconds: float = 0.0,
    settings: str = "",
    picture: str = "optical-flow.svg",
    film: str = "optical-flow.gif",
    page: int = -1,
) -> None:
    """Wander by optical flow until stopped.

    Args:
        team: The robots on the bus.
        robot: Its name; any robot with a camera if empty. Its camera head is turned ahead.
        seconds: For which it wanders; 0 for ever.
        settings: A file with changes of `settings.toml`.
        picture: File for the plots at the end; none if empty.
        film: File, .gif or .mp4, for frames with flow and time to contact; none if empty.
        page: TCP port of the live page, 0 for any free one; no page below 0.
    Raises:
        RobotError: An argument is not valid, or the robot or its camera is missing.
    """
    tuned = _settings(settings)
    _check_file("picture", picture, PLOTS)
    _check_file("film", film, ENDINGS)
    if not (math.isfinite(seconds) and seconds >= 0.0):
        raise RobotError(f"seconds must be 0 or more, not {seconds:g}; 0 wanders for ever")
    me = team.robot(robot, having=("base", "camera"))
    hull = tuned.robot
    check_hull(me, length_front=hull.front_m, length_rear=hull.rear_m, width=hull.width_m)
    if me.has("ptz"):
        me.ptz.look(pan=0.0, tilt=0.0, zoom=1.0)
    feed = FlowFeed(me)
    writer = _writer(film, tuned)
    flow = me.element("flow")
    found = _options(flow)
    record = FlowRecord(me.name)
    _running.record, _running.orders, _running.settings = record, None, tuned
    with ExitStack() as at_end:
        served = _page(page, record, tuned, at_end)
        # Dense, 16 columns: what the settings are made for.
        flow.ask("configure", vectors=bool(writer or served), ahead=tuned.robot.camera_m)
        at_end.callback(_finish, record, picture, writer)
        at_end.callback(_restore, flow, found)
        at_end.callback(feed.close)
        at_end.callback(stop_first, [me])
        _wander(team, me, feed, record, _Showing(feed, tuned, writer, served), seconds)
        me.base.stop()


@request("status")
def status() -> dict[str, Any]:
    """Return the situation with its reason, and what has been driven and visited so far."""
    record, orders = _running.record, _running.orders
    if record is None or orders is None:
        raise RobotError("the robot has not begun to wander yet; ask again in a moment")
    return {
        "robot": record.robot,
        "situation": orders.situation.value,
        "reason": orders.reason,
        "linear": orders.twist.linear,
        "angular": orders.twist.angular,
        "seconds": record.times[-1] if record.times else 0.0,
        "metres": round(record.way, 2),
        "visited": round(record.visited(_running.settings.coverage.width_m), 2),
        "touches": record.touches,
    }


class _Showing:
    """Puts images with their flow into the film and on the page, no more of them than these need."""

    def __init__(
        self, feed: FlowFeed, settings: FlowSettings, writer: FilmWriter | None, page: "FlowPage | None"
    ) -> None:
        self._feed, self._settings, self._writer, self._page = feed, settings, writer, page
        self._next_frame = self._next_view = 0.0  # s

    @property
    def is_stopped(self) -> bool:
        """Whether somebody has ended the drive from the page."""
        return self._page is not None and self._page.is_stopped

    def step(self, now: float, orders: WanderOrders) -> None:
        """Show what there is at a time, s."""
        if self._page is not None:
            self._page.orders = orders
        writer = self._writer if now >= self._next_frame else None
        page = self._page if self._page is not None and self._page.is_watched and now >= self._next_view else None
        if writer is None and page is None:
            return
        view = self._feed.view(f"{now:.0f} s  {orders.situation.value}: {orders.reason}")
        if view is None:
            return
        if writer is not None:
            self._next_frame = now + 1.0 / self._settings.film.rate
            writer.add(view.frame())
        if page is not None:
            self._next_view = now + 1.0 / self._settings.page.rate
            page.show(view)


def _wander(team: Team, me: Robot, feed: FlowFeed, record: FlowRecord, showing: _Showing, seconds: float) -> None:
    """Drive until the program is to end, the time is over, or somebody ends the drive from the page."""
    settings = _running.settings
    wanderer = Wanderer(settings)
    next_report, refusal = settings.report_s, ""
    _tell(record, 0.0, f"{me.name} wanders by optical flow at {settings.drive.speed_m_s:g} m/s")
    for now in team.every(settings.period_s):
        if showing.is_stopped:
            _tell(record, now, "stopped from the page")
            return
        readings = feed.read(now, settings.period_s / 2.0)
        if readings is None:
            continue
        orders = _running.orders = wanderer.step(readings)
        before, refusal = refusal, _driven(me, feed, orders)
        if refusal and refusal != before:
            _tell(record, now, refusal)
        if orders.changed:
            _tell(record, now, f"{orders.situation.value}: {orders.reason}")
        record.touches = wanderer.contacts
        record.add(now, readings.pose, least_contact(readings.columns), orders.situation)
        showing.step(now, orders)
        me.show("flow", f"{orders.situation.value}: {orders.reason}", lines=_arrow(orders))
        if now >= next_report:
            next_report = now + settings.report_s
            width = settings.coverage.width_m
            _tell(record, now, f"{record.way:.1f} m driven, {record.visited(width):.1f} m^2 of floor visited")
        if seconds and now >= seconds:
            return


def _arrow(orders: WanderOrders) -> list[tuple[Point, Point]]:
    """Return where the robot drives in the next two seconds, a line in base_link."""
    turn = orders.twist.angular * _AHEAD / 2.0
    far = orders.twist.linear * _AHEAD
    return [((0.0, 0.0), (far * math.cos(turn), far * math.sin(turn)))] if far > 0.0 else []


def least_contact(columns: FlowColumns | None) -> float:
    """Return the least time to contact in the columns, s; NaN where none is known."""
    if columns is None or np.isnan(columns.rates).all():
        return math.nan
    return float(1.0 / max(np.nanmax(columns.rates), 1e-3))


def _driven(me: Robot, feed: FlowFeed, orders: WanderOrders) -> str:
    """Drive as ordered; returns why the robot refuses, in words, or nothing."""
    try:
        me.base.drive(orders.twist.linear, orders.twist.angular)
    except Failed:  # it is stalled: something blocks it
        feed.has_stalled()
    except Refused as err:
        return str(err)
    return ""


def _tell(record: FlowRecord, now: float, told: str) -> None:
    record.told.append(f"{now:.1f} s: {told}")
    print(record.told[-1], flush=True)


def _finish(record: FlowRecord, picture: str, writer: FilmWriter | None) -> None:
    """Print the summary, and write picture and film."""
    if not record.times:
        return
    width = _running.settings.coverage.width_m
    print(f"after {record.times[-1]:.0f} s:", *record.summary(width), sep="\n  ", flush=True)
    try:
        if picture:
            draw_wandering(Path(picture), record, f"{record.robot} by optical flow, poses by odometry")
            print(f"see {picture}", flush=True)
        if writer is not None and (count := writer.close()):
            print(f"see {writer.file}, {count} frames", flush=True)
    except (OSError, ExtraMissing) as err:
        print(f"no picture: {err}", flush=True)


def _restore(flow: ElementClient[Any], options: dict[str, Any]) -> None:
    with suppress(RobotError, Stopped):  # the agent may have gone, and the program is ending
        flow.ask("configure", **options)


def _options(flow: ElementClient[Any]) -> dict[str, Any]:
    """Return the options of the flow agent that other programs use now, as a result of it shows them."""
    try:
        result = flow.ask("read")
    except RobotError:  # there are no images yet, so nobody has results that could change
        return {}
    return {
        "method": result["method"],
        "columns": len(result["flow"]),
        "vectors": "vectors" in result,
        "ahead": result["ahead"],
    }


def _writer(film: str, settings: FlowSettings) -> FilmWriter | None:
    if not film:
        return None
    try:
        require("the film", "vision", "plots")
    except ExtraMissing as err:
        raise RobotError(f"{err}; film= does without") from err
    return FilmWriter(Path(film), round(settings.film.longest_s * settings.film.rate))


def _page(port: int, record: FlowRecord, settings: FlowSettings, at_end: ExitStack) -> "FlowPage | None":
    """Serve the page until the end; None if none is wanted."""
    if port < 0:
        return None
    if port >= 1 << 16:
        raise RobotError(f"page={port} is not a TCP port; give a number from 0 to 65535")
    try:
        require("the page", "console", "vision")
        from apps.optical_flow.page import FlowPage

        page = FlowPage(port, record, settings.page)
    except configs.ConfigError as err:  # an extra is missing as well
        raise RobotError(str(err)) from err
    at_end.callback(page.close)
    print(f"live page of {record.robot}: {page.url}", flush=True)
    return page


def _settings(file: str) -> FlowSettings:
    try:
        return FlowSettings.load(file)
    except configs.ConfigError as err:
        raise RobotError(str(err)) from err


def _check_file(name: str, given: str, endings: tuple[str, ...]) -> None:
    file = Path(given)
    if given and (file.suffix not in endings or not file.parent.is_dir()):
        raise RobotError(
            f"the {name} {given} cannot be written; name a file that ends in {' or '.join(endings)}, "
            "in a folder that exists"
        )
