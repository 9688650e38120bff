"""Every element that a driver looks after, in the order in which they are asked."""

from gateway.elements.arm import ArmElement
from gateway.elements.batteries import Batteries
from gateway.elements.compass import CompassElement
from gateway.elements.configuration import ControllerConfiguration
from gateway.elements.element import Element
from gateway.elements.encoders import WheelEncoders
from gateway.elements.gripper import GripperElement
from gateway.elements.gyro import Gyro
from gateway.elements.infrared import InfraredElement
from gateway.elements.joystick import JoystickElement
from gateway.elements.panel import ChargerElement, Display, PowerOutputs, Servos
from gateway.elements.ports import UserPorts
from gateway.elements.ptz import PtzElement
from gateway.elements.simulated_laser import SimulatedLaserScanner
from gateway.elements.sonar import SonarElement
from gateway.elements.sound import SoundElement

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
