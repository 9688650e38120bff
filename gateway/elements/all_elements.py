"""Every element that a driver looks after, in the order in which they are asked."""

from gateway.elements.arm import Arm
from gateway.elements.batteries import Batteries
from gateway.elements.compass import Compass
from gateway.elements.configuration import ControllerConfiguration
from gateway.elements.element import Element
from gateway.elements.encoders import WheelEncoders
from gateway.elements.gripper import Gripper
from gateway.elements.gyro import Gyro
from gateway.elements.infrared import Infrared
from gateway.elements.joystick import Joystick
from gateway.elements.panel import Charger, Display, PowerOutputs, Servos
from gateway.elements.ports import UserPorts
from gateway.elements.ptz import Ptz
from gateway.elements.simulated_laser import SimulatedLaserScanner
from gateway.elements.sonar import Sonar
from gateway.elements.sound import Sound

ELEMENTS: tuple[type[Element], ...] = (
    ControllerConfiguration,
    Sonar,
    UserPorts,
    WheelEncoders,
    Gyro,
    Gripper,
    Arm,
    Infrared,
    Charger,
    Servos,
    PowerOutputs,
    Display,
    Sound,
    Batteries,
    Compass,
    Joystick,
    Ptz,
    SimulatedLaserScanner,
)
