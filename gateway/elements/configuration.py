"""What the controller is and is set to: every other element may learn from it what the robot has."""

from gateway.elements.asked import AskedElement
from p2os import Command, Configuration


class ControllerConfiguration(AskedElement):
    """Asks for the CONFIGpac; firmware before P2OS 1.4 has none."""

    takes = (Configuration,)
    question = Command.CONFIG, None
    period = 0.25
    times = 6
