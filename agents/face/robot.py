"""A robot, as a program sees it: its name and its elements."""

from typing import TypeVar, cast

from agents.face.element import Element
from agents.face.errors import RobotError
from agents.face.horizon import Horizon
from agents.face.movers import Arm, Base, Gripper, Ptz
from agents.face.readings import Reading
from agents.face.sensors import (
    Battery,
    Bumpers,
    Camera,
    Compass,
    Infrared,
    Io,
    Joystick,
    Laser,
    Sonar,
    Sound,
)
from agents.face.stage import Stage
from agents.platform import AgentName, NameNotValid

ELEMENTS: dict[str, type[Element[Reading]]] = {
    name: cast(type[Element[Reading]], kind)
    for name, kind in {
        "base": Base,
        "sonar": Sonar,
        "laser": Laser,
        "bumpers": Bumpers,
        "ir": Infrared,
        "battery": Battery,
        "io": Io,
        "gripper": Gripper,
        "arm": Arm,
        "ptz": Ptz,
        "camera": Camera,
        "sound": Sound,
        "joystick": Joystick,
        "compass": Compass,
    }.items()
}

E = TypeVar("E", bound=Element)  # type: ignore[type-arg]  # whatever it reads


class Robot:
    """One robot. Asking for an element that it has not raises `NotThere`, which says what it has.

    name: on the bus.
    """

    def __init__(self, stage: Stage, horizon: Horizon, name: str) -> None:
        self.name = name
        self._stage = stage
        self._horizon = horizon
        self._elements: dict[str, Element[Reading]] = {}

    @property
    def elements(self) -> list[str]:
        """The names of the elements that it has now."""
        return self._stage.call(self._horizon.elements(self.name))

    def has(self, element: str) -> bool:
        """Whether it has an element now."""
        return element in self.elements

    def element(self, name: str) -> Element[Reading]:
        """An element by its name, also one without a class of its own: `robot.element("gyro").read()`.

        Raises:
            NotThere: It has none; says what it has.
        """
        if name not in self._elements:
            try:
                agent = AgentName(name, self.name)
            except NameNotValid as err:
                raise RobotError(str(err)) from err
            self._stage.call(self._horizon.element(agent))
            self._elements[name] = ELEMENTS.get(name, Element)(self._stage, agent)
        return self._elements[name]

    def stop(self) -> None:
        """Stop it."""
        self.base.stop()

    @property
    def base(self) -> Base:
        """Wheels and odometry."""
        return self._element("base", Base)

    @property
    def sonar(self) -> Sonar:
        """The ring of sonar discs."""
        return self._element("sonar", Sonar)

    @property
    def laser(self) -> Laser:
        """The laser scanner."""
        return self._element("laser", Laser)

    @property
    def bumpers(self) -> Bumpers:
        """What feels contact."""
        return self._element("bumpers", Bumpers)

    @property
    def ir(self) -> Infrared:
        """Infrared range sensors."""
        return self._element("ir", Infrared)

    @property
    def battery(self) -> Battery:
        """The battery."""
        return self._element("battery", Battery)

    @property
    def io(self) -> Io:
        """The user's inputs and outputs."""
        return self._element("io", Io)

    @property
    def gripper(self) -> Gripper:
        """Two paddles on a lift."""
        return self._element("gripper", Gripper)

    @property
    def arm(self) -> Arm:
        """The arm."""
        return self._element("arm", Arm)

    @property
    def ptz(self) -> Ptz:
        """The head that points the camera."""
        return self._element("ptz", Ptz)

    @property
    def camera(self) -> Camera:
        """The camera."""
        return self._element("camera", Camera)

    @property
    def sound(self) -> Sound:
        """Buzzer or loudspeaker."""
        return self._element("sound", Sound)

    @property
    def joystick(self) -> Joystick:
        """The joystick on the robot."""
        return self._element("joystick", Joystick)

    @property
    def compass(self) -> Compass:
        """The compass."""
        return self._element("compass", Compass)

    def __repr__(self) -> str:
        return f"<Robot {self.name}>"

    def _element(self, name: str, kind: type[E]) -> E:
        element = self.element(name)
        assert isinstance(element, kind)
        return element
