"""Every element that a driver looks after, in the order in which they are asked."""

from gateway.elements.arm.element import ArmElement
from gateway.elements.batteries import Batteries
from gateway.elements.compass.element import CompassElement
from gateway.elements.configuration import ControllerConfiguration
from gateway.elements.element import Element
from gateway.elements.encoders import WheelEncoders
from gateway.elements.gripper.element import GripperElement
from gateway.elements.gyro.element import Gyro
from gateway.elements.infrared.element import InfraredElement
from gateway.elements.joystick.element import JoystickElement
from gateway.elements.panel.element import ChargerElement, Display, PowerOutputs, Servos
from gateway.elements.ports import UserPorts
from gateway.elements.ptz.element import PtzElement
from gateway.elements.simulated_laser.element import SimulatedLaserScanner
from gateway.elements.sonar import SonarElement
from gateway.elements.sound.element import SoundElement

ELEMENTS: tuple[type[Element], ...] = (
    ControllerConfiguration,
    SonarElement,
    UserPorts,
    WheelEncoders,
    Gyro,
    GripperElement,
    ArmElement,
    InfraredElement,
    ChargerElement,
    Servos,
    PowerOutputs,
    Display,
    SoundElement,
    Batteries,
    CompassElement,
    JoystickElement,
    PtzElement,
    SimulatedLaserScanner,
)
