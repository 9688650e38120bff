"""Environment of a scene: an emulated robot, its gateway, the bus, and printed comments."""

import math
import queue
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from acromovi.children import EmulatedRobots, emulator, gateway
from bus import Bus, NoAnswer, Refused, Sample, ZenohBus, keys, messages
from bus.heartbeat import Heartbeat
from bus.keys import Topic

PATIENCE_S = 30.0  # a gateway connects in 2 s, at a load of ten for each core in 20 s
DRIVING_PERIOD_S = 0.1
HELD_UP = ("the robot is not connected", "the gateway has just been frozen", "the camera head has not answered yet")
"""Beginnings of what a gateway says that refuses a command because the machine keeps it from its work."""
MOST_LOOKS = MOST_MOTIONS = 3  # times that a motion is told which a busy machine has interrupted
THERE = 0.02  # rad that a head may be off when it has got there


class SceneFailed(Exception):
    """An expected event of a scene did not happen; the message names it."""


@dataclass(frozen=True, slots=True)
class Scene:
    """A short demonstration with one robot.

    name: what one types. shows: for people. emulator, gateway: their arguments; `{laser_port}` and the like stand for
    what the emulator says of its robot, `{name}` and `{folder}` for the robot's name and a folder of the scene's own.
    play: what happens. has_gateway: a gateway is started; without it the robot's port is free for the scene.
    """

    name: str
    shows: str
    emulator: str
    play: "Callable[[SceneStage], None]"
    gateway: str = ""
    has_gateway: bool = True


class SceneStage:
    """Robot, bus and output of a scene.

    robot: its name. robots: the emulator. folder: of the scene's own, removed with it.
    """

    def __init__(self, robot: str, robots: EmulatedRobots, bus: Bus, folder: Path, say: Callable[[str], None]) -> None:
        self.robot = robot
        self.robots = robots
        self.folder = folder
        self.say = say
        self._bus = bus
        self._heartbeat = Heartbeat(bus, f"{robot}-scene/heartbeat")

    def close(self) -> None:
        """End what the scene has set going."""
        self._heartbeat.close()

    def ask(self, do: str, **arguments: Any) -> dict[str, Any]:
        """Ask the emulator's control socket."""
        return self.robots.ask(do, **arguments)

    def truth(self) -> dict[str, Any]:
        """Everything that the emulator knows of the robot."""
        return dict(self.ask("truth")["robots"][self.robot])

    def tell(self, topic: Topic, **arguments: Any) -> dict[str, Any]:
        """Give the robot a command; returns its answer.

        A busy machine may lose the robot for a moment, or freeze its gateway: that is waited for.

        Raises:
            Refused: It does not obey.
            SceneFailed: Nobody answers.
        """
        deadline = time.monotonic() + PATIENCE_S
        while True:
            try:
                return self._tell(topic, arguments)
            except Refused as refusal:
                if not refusal.why.startswith(HELD_UP) or time.monotonic() > deadline:
                    raise
                time.sleep(0.1)

    def is_refused(self, topic: Topic, **arguments: Any) -> str:
        """Give the robot a command that it must refuse; returns why it does.

        Raises:
            SceneFailed: It obeys.
        """
        try:
            self._tell(topic, arguments)
        except Refused as refusal:
            return str(refusal)
        raise SceneFailed(f"{topic.suffix} {arguments} was not refused")

    def _tell(self, topic: Topic, arguments: dict[str, Any]) -> dict[str, Any]:
        if topic in keys.MOTIONS:
            arguments = {"heartbeat": self._heartbeat.key, **arguments}
        try:
            (answer,) = self._bus.query(topic.key(self.robot), arguments, PATIENCE_S)
        except NoAnswer as error:
            raise SceneFailed(str(error)) from error
        return answer.value

    def see(
        self, topic: Topic, wanted: Callable[[Any], bool] = lambda _: True, what: str = "", within: float = PATIENCE_S
    ) -> Any:
        """The next message that is wanted.

        Args:
            topic: Where it comes.
            wanted: Says whether it is the one.
            what: What is waited for, for the message if it does not come.
            within: s.
        Raises:
            SceneFailed: It did not come.
        """
        arrived: queue.SimpleQueue[Sample] = queue.SimpleQueue()
        deadline = time.monotonic() + within
        with self._bus.subscribe(topic.key(self.robot), arrived.put):
            while (left := deadline - time.monotonic()) > 0.0:
                try:
                    sample = arrived.get(timeout=left)
                except queue.Empty:
                    break  # the time is over, which is told below
                message = messages.decode(topic.type_name, sample.payload)
                if wanted(message):
                    return message
        raise SceneFailed(
            f"{self.robot}/{topic.suffix}: {what or 'nothing'} did not come within {within:g} s{self._given_up()}"
        )

    def _given_up(self) -> str:
        """Return what the emulator has given up, as the end of a message; empty where it keeps up."""
        degraded = self.ask("truth").get("degraded")
        return f"; the machine is too busy, and the emulator has given up {' and '.join(degraded)}" if degraded else ""

    def look(self, pan: float, tilt: float = 0.0, zoom: float = 1.0) -> Any:
        """Turn the camera head, rad, and wait until it is there; returns what it tells then.

        A gateway that a busy machine freezes has the head stop on its way, so it may be told more than once.

        Raises:
            Refused: It does not obey.
            SceneFailed: It does not get there.
        """
        for _ in range(MOST_LOOKS):
            self.tell(keys.LOOK, pan=pan, tilt=tilt, zoom=zoom)
            head = self.see(keys.PTZ, lambda head: not head.moving, "a head at rest")
            if max(abs(head.pan - pan), abs(head.tilt - tilt)) < THERE:
                return head
        raise SceneFailed(f"the head stopped short of its goal {MOST_LOOKS} times, at last at {head.pan:.2f} rad")

    def wait(self, condition: Callable[[], bool], what: str, within: float = PATIENCE_S) -> None:
        """Wait for something that the emulator shows.

        Raises:
            SceneFailed: It did not come to pass.
        """
        deadline = time.monotonic() + within
        while not condition():
            if time.monotonic() > deadline:
                raise SceneFailed(f"{what} did not come to pass within {within:g} s")
            time.sleep(0.02)

    def drive(self, linear: float, angular: float, seconds: float) -> None:
        """Send a velocity, m/s and rad/s, for so long, and then a stop."""
        twist = messages.twist(linear, angular)
        for _ in range(math.ceil(seconds / DRIVING_PERIOD_S)):
            self._bus.put(keys.CMD_VEL.key(self.robot), twist)
            time.sleep(DRIVING_PERIOD_S)
        self._bus.put(keys.CMD_VEL.key(self.robot), messages.twist(0.0, 0.0))

    def elements(self) -> list[str]:
        """The names of the elements that the robot's description lists."""
        return [element["name"] for element in self.tell(keys.DESCRIPTION)["elements"]]

    def wait_for_element(self, name: str) -> None:
        """Wait until the gateway has found out that the robot has an element.

        Raises:
            SceneFailed: It did not.
        """
        self.wait(lambda: name in self.elements(), f"an element {name!r} in the description")


@contextmanager
def set_stage(scene: Scene, robot: str, say: Callable[[str], None]) -> Iterator[SceneStage]:
    """Start emulator and gateway of a scene, and wait until the robot is on the bus.

    Args:
        scene: Which.
        robot: What to call it.
        say: Takes a sentence for people.
    """
    with ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="acromovi-try-"))
        arguments = [word.replace("{name}", robot).replace("{folder}", folder) for word in scene.emulator.split()]
        robots = stack.enter_context(emulator("--quiet", *arguments))
        say(f"$ p2os-emu {' '.join(arguments)}")
        stage = SceneStage(robot, robots, stack.enter_context(ZenohBus.open()), Path(folder), say)
        stack.callback(stage.close)
        if scene.has_gateway:
            facts = {key: value or "" for key, value in robots.robots[0].items()}
            options = [word.format_map(facts) for word in scene.gateway.split()]
            say(f"$ p2os-gateway {' '.join([robots.port, *options])}")
            stack.enter_context(gateway(robots.port, "--quiet", *options))
            stage.see(keys.ODOM, what="odometry")
        yield stage
