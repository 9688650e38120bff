"""The board: all of the microcontroller but its connection. Commands change it, packets show it, steps move it."""

from collections.abc import Callable
from random import Random

from p2os.arguments import DockMode, PacketRequest
from p2os.command_table import known_commands
from p2os.configuration import AutoBaud
from p2os.firmware import BAUD_CODES, FIRMWARES
from p2os.packets import Packet, PacketType
from p2os.robot_model import RobotModel
from p2os_emu.body import Body, BodyState
from p2os_emu.device import Device
from p2os_emu.microcontroller.arm import ArmServer
from p2os_emu.microcontroller.aux_port import AuxPort
from p2os_emu.microcontroller.battery import BatteryModel, ChargerContacts
from p2os_emu.microcontroller.buzzer import Buzzer
from p2os_emu.microcontroller.compass import CompassServer
from p2os_emu.microcontroller.flash import Flash
from p2os_emu.microcontroller.gripper import GripperServer
from p2os_emu.microcontroller.gyro import GyroServer
from p2os_emu.microcontroller.motion import MotionController
from p2os_emu.microcontroller.motors import AT_REST, Motors
from p2os_emu.microcontroller.odometry import OdometryIntegrator
from p2os_emu.microcontroller.outputs import Outputs
from p2os_emu.microcontroller.panel import JoystickServer, Panel
from p2os_emu.microcontroller.simulator import Simulator
from p2os_emu.microcontroller.sonar import SonarScheduler
from p2os_emu.microcontroller.timers import ClientWatchdog

GAINS = ("rot_kp", "rot_kv", "rot_ki", "trans_kp", "trans_kv", "trans_ki")


class _Requests:
    """Packets to send with the next SIP, or with every SIP."""

    __slots__ = ("_wanted",)

    def __init__(self) -> None:
        self._wanted: dict[PacketType, int] = {}

    def clear(self) -> None:
        """Send nothing more."""
        self._wanted.clear()

    def ask(self, packet: PacketType, count: int) -> None:
        """Ask for a packet: 0 stops it, 1 asks for one, 2 and more for one with every SIP."""
        if count <= 0:
            self._wanted.pop(packet, None)
        else:
            self._wanted[packet] = min(count, PacketRequest.CONTINUOUS)

    def take(self) -> list[PacketType]:
        """The packets for this SIP, lowest type first."""
        if not self._wanted:
            return []
        due = sorted(self._wanted)
        self._wanted = {packet: count for packet, count in self._wanted.items() if count == PacketRequest.CONTINUOUS}
        return due


class Board:
    """One robot's controller board.

    gains: working PID gains by name; accepted and reported, the wheels follow their profiles by other means.
    ticks_mm, rev_count, drift_factor: working calibration, see `calibrate`.
    stops_on_button: the STOP button disables the motors (ESTALL). e_stalled: it has done so.
    digital_out: levels of the user outputs, bit 0 to 7. analog_port: the one that the SIP reports.
    fake_battery: V that BATTEST pretends, None for the real ones.
    host_baud: bit/s of the host line. next_baud: its rate from the next step on, when the bytes of this one have gone
    out. reset_due: RESET was commanded. in_maintenance: only the power switch helps.
    known: numbers of the commands that this firmware knows. time: s since power-on.
    has_client: a connection is open. answers: packets for the client that follow the next SIP.
    aux: the AUX ports, 1 to 3. gyro, compass: their servers, where they are fitted. gyro_cw, gyro_ccw: calibration of
    the gyro; accepted and reported, since no source gives its unit. simulator: commands that no real robot knows.
    temperature: °C that a test command pretends, None for unknown. shutdown_wanted: the computer is told to shut down.
    """

    def __init__(self, model: RobotModel, name: str, flash: Flash, panel: Panel, seed: int) -> None:
        """Switch on.

        Args:
            model: What the robot is.
            name: What it is called.
            flash: What the controller remembers.
            panel: Inputs from outside.
            seed: Decides the charge of the battery.
        """
        self.model = model
        self.name = name
        self.flash = flash
        self.panel = panel
        self.odometry = OdometryIntegrator(model)
        self.motion = MotionController(model, flash, self.odometry)
        self.motors = Motors(self.motion, flash)
        self.sonar = SonarScheduler(model, flash)
        self.battery = BatteryModel(model.battery_nominal, seed)
        self.watchdog = ClientWatchdog(flash.watchdog)
        self.requests = _Requests()
        self.gripper = GripperServer()
        self.arm = ArmServer()
        self.known = known_commands(model.firmware, FIRMWARES[model.firmware].version)
        self.answers: list[Packet] = []
        self.aux = {port: AuxPort(port, flash.aux_baud, Random(f"{seed} AUX{port}")) for port in (1, 2, 3)}
        self._used_ports: tuple[AuxPort, ...] = ()
        self.buzzer = Buzzer(model.firmware)
        self.charger = ChargerContacts()
        self.joystick = JoystickServer(flash)
        self.gyro: GyroServer | None = None
        self.compass: CompassServer | None = None
        self.simulator: Simulator | None = None
        self.time = 0.0
        self.power_on()

    def power_on(self) -> None:
        """Begin as after the power switch; the battery's charge stays what it is."""
        self.host_baud = self.flash.host_baud
        self.next_baud = self.flash.host_baud
        self.digital_out = 0
        self.fake_battery: float | None = None
        self.reset_due = False
        self.in_maintenance = False
        self.temperature: float | None = None
        self.outputs = Outputs()
        for port in self.aux.values():
            port.baud = self.flash.aux_baud
        if self.gyro is not None:
            self.gyro.power_on()
        if self.compass is not None:
            self.compass.power_on()
        self.odometry.power_on()
        self.gripper.power_on()
        self.arm.power_on()
        self.restore()

    def open(self) -> None:
        """Open a connection: motors off, sonar as in FLASH."""
        self.has_client = True
        self.motors.disable()
        self.e_stalled = False
        self.sonar.enable(self.flash.sonar_enabled)
        self.watchdog.feed()

    def restore(self) -> None:
        """Handle the end of the connection: motors and sonar off, working parameters as in FLASH."""
        flash = self.flash
        self.has_client = False
        if flash.auto_baud == AutoBaud.PER_CLIENT:
            self.next_baud = flash.host_baud
        self.answers.clear()
        self.joystick.restore()
        self.charger.release()
        self.charger.docking = DockMode.OFF
        self.buzzer.on = True
        self.shutdown_wanted = False
        self.gyro_cw = self.gyro_ccw = 0
        if self.gyro is not None:
            self.gyro.restore()
        if self.compass is not None:
            self.compass.restore()
        if self.simulator is not None:
            self.simulator.restore()
        self.motion.restore(flash)
        self.motors.restore(flash)
        self.sonar.restore(flash)
        self.watchdog.timeout = flash.watchdog
        self.watchdog.feed()
        self.requests.clear()
        for port in self.aux.values():
            port.clear()  # nobody waits any more for what was asked for
        self.gripper.halt()
        self.arm.restore()
        self.gains = {name: getattr(flash, name) for name in GAINS}
        self.stops_on_button = flash.e_stall
        self.e_stalled = False
        self.analog_port = 0
        self.ticks_mm = flash.ticks_mm
        self.rev_count = flash.rev_count
        self.drift_factor = flash.drift_factor
        self.calibrate()

    def calibrate(self) -> None:
        """Bring odometry in line with the working calibration."""
        flash = self.flash
        drift = self.drift_factor - flash.drift_factor
        self.odometry.calibrate(self.ticks_mm / flash.ticks_mm, self.rev_count / flash.rev_count, drift)

    def request_baud(self, code: int) -> None:
        """Change the rate of the host line once what this step sends has gone out; unknown codes are ignored."""
        self.next_baud = BAUD_CODES.get(code, self.next_baud)

    def enable_motors(self, on: bool) -> None:
        """ENABLE; a pressed STOP button keeps the motors off."""
        if not on:
            self.motors.disable()
        elif self.may_enable:
            self.e_stalled = False
            self.charger.release()
            self.motors.enable()

    @property
    def may_enable(self) -> bool:
        """No STOP button keeps the motors off."""
        return not (self.panel.stop_button and self.stops_on_button)

    def charge(self, on: bool) -> None:
        """CHARGE; a robot without a charger ignores it."""
        if not self.flash.charger:
            return
        if on:
            self.motors.disable()
            self.charger.deploy()
        else:
            self.charger.release()

    @property
    def battery_voltage(self) -> float:
        """Measured voltage, V: that of BATTEST, else of the panel, else of the battery."""
        for voltage in (self.fake_battery, self.panel.battery):
            if voltage is not None:
                return max(0.0, voltage)
        return self.battery.voltage

    def advance(self, body: Body, state: BodyState, dt: float) -> None:
        """Take one step: watchdog, encoders, gyro, joystick, motors, sonar, gripper, arm, AUX ports."""
        self.time += dt
        watchdog = self.watchdog
        if self.has_client:
            watchdog.advance(dt)
        turned = None if self.gyro is None else self._turned(self.gyro, state, dt)
        self.odometry.update(state.left_travel, state.right_travel, turned)
        panel = self.panel
        if panel.stop_button and self.stops_on_button:
            self.e_stalled = True
            self.motors.brake_and_disable()
        if panel.joystick is not None:
            self.joystick.advance(panel.joystick, self.motors, self.motion, self.has_client, self.may_enable)
        self.motion.halted = watchdog.barking and not self.joystick.driving
        self.motors.advance(body, state, dt)
        self.sonar.advance(body, dt)
        if self.gripper.kind:
            self.gripper.advance(body.gripper, dt)
        if self.arm.is_fitted:
            self.arm.advance(body.arm, dt, is_deserted=watchdog.barking)
        for port in self._used_ports:
            port.advance(dt)

    def plug(self, port: int, make: Callable[[], Device]) -> None:
        """Plug a device into an AUX port, 1 to 3; make: makes it as it is after the power switch."""
        self.aux[port].plug(make)
        self._used_ports = tuple(each for each in self.aux.values() if each.device is not None)

    def _turned(self, gyro: GyroServer, state: BodyState, dt: float) -> float | None:
        """Rad that the gyro inside the controller has turned in this step; None where the wheels decide."""
        standing = abs(state.left_velocity) < AT_REST and abs(state.right_velocity) < AT_REST
        failed = self.panel.gyro_failed
        gyro.advance(state.turn_rate, standing, failed, dt)
        return gyro.turned(standing, failed, dt)

    def consume(self, body: Body, state: BodyState, dt: float) -> None:
        """Once a cycle of `dt`, s: draw from the battery or charge it, and read the compass."""
        charger = self.charger
        power_came = charger.advance(dt, self.panel.charger_plugged, self.panel.docked or body.is_docked)
        if power_came and charger.docking == DockMode.STOP_AT_POWER:
            self.motion.stop()
        self.battery.advance(dt, (state.left_load + state.right_load) / 2, charger.power_good)
        if self.compass is not None:
            report = self.compass.advance(state, dt)
            if report is not None:
                self.answers.append(report)
