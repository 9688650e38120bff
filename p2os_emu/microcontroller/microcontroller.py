"""The firmware of a robot, without port and clock: bytes and time in, bytes out."""

from math import inf

from p2os.accessory_packets import Reset
from p2os.framing import Frame, FrameDecoder, encode_frame
from p2os.handshake import ConnectionState, Identity, RobotHandshake
from p2os.packets import Packet, PacketType, encode_packet
from p2os.robot_model import RobotModel
from p2os.sip import SipCodec
from p2os_emu.body import Body, BodyState
from p2os_emu.fit import BARE, Fit
from p2os_emu.microcontroller.board import Board
from p2os_emu.microcontroller.buzzer import PlayedNote
from p2os_emu.microcontroller.commands import execute
from p2os_emu.microcontroller.flash import Flash
from p2os_emu.microcontroller.panel import CENTRED, Panel
from p2os_emu.microcontroller.telemetry import AHEAD, EXTRAS, answers, standard_sip
from p2os_emu.microcontroller.timers import TOLERANCE, Cadence


class Microcontroller:
    """One robot's controller: between a serial line and a body.

    Its time is the sum of the steps. Commands received take effect at the start of the next step.

    panel: inputs from outside the cable; change them at any time. fit: its accessories. board: all but the connection.
    """

    def __init__(
        self, model: RobotModel, name: str, *, flash: Flash | None = None, seed: int = 0, fit: Fit = BARE
    ) -> None:
        """Switch the robot on.

        Args:
            model: What it is.
            name: What it answers to SYNC2, at most 19 characters.
            flash: What it remembers from before; None for the factory's values.
            seed: Decides what chance would: the charge that the battery starts with.
            fit: The accessories, which its servers answer for.
        Raises:
            LocalProtocolError: The name does not fit the handshake.
            EncodeError: A FLASH parameter does not fit CONFIGpac.
        """
        self.panel = Panel(joystick=CENTRED if fit.has("joystick") else None)
        self.fit = fit
        self.board = Board(model, name, flash or Flash.of(model, name, seed), self.panel, seed)
        self._handshake = RobotHandshake(Identity(name, model.robot_class, model.name))
        self._codec = SipCodec(model)
        self._sip_clock = Cadence(self.board.flash.sip_cycle)
        self._decoder = FrameDecoder()
        self._inbox = bytearray()
        self._outbox: list[bytes] = []
        encode_packet(EXTRAS[PacketType.CONFIGURATION](self.board, BodyState()), model)

    @property
    def connected(self) -> bool:
        """A client has opened the connection."""
        return self._handshake.state is ConnectionState.OPEN

    @property
    def silence(self) -> float:
        """Time in which the firmware sends nothing unless it receives something, s."""
        if self._inbox or self._outbox:
            return 0.0
        return self._sip_clock.left - TOLERANCE if self.connected else inf

    @property
    def notes(self) -> tuple[PlayedNote, ...]:
        """Last notes of the buzzer, oldest first."""
        return tuple(self.board.buzzer.notes)

    @property
    def sounds(self) -> bool:
        """The buzzer plays something."""
        return self.board.buzzer.plays(self.board.time)

    def power_cycle_aux(self) -> None:
        """Switch the devices on the AUX ports off and on, as the robot's power switch does."""
        for port in self.board.aux.values():
            port.power_cycle()

    @property
    def simulator_messages(self) -> tuple[str, ...]:
        """Messages of clients to the simulator and its refusals, oldest first."""
        return tuple(self.board.simulator.messages) if self.board.simulator else ()

    def forget_travels(self) -> None:
        """Put the odometry to zero, as SETO does."""
        self.board.odometry.reset()
        self.board.motion.forget_heading()

    def receive(self, data: bytes) -> None:
        """Take bytes from the line."""
        self._inbox += data

    def power_cycle(self, reason: bytes = b"") -> None:
        """Lose power for a moment: a connected client is told, then everything is as after the power switch.

        Args:
            reason: What the reset packet says beside that; it has another type then.
        """
        if self.connected:
            self._say(Reset(reason))
        self._handshake.reset()
        self._decoder = FrameDecoder()
        self._inbox.clear()
        self.board.power_on()

    def step(self, dt: float, body: Body) -> bytes:
        """Take one step.

        Args:
            dt: s.
            body: The machine, as the last physics step left it.
        Returns:
            Everything to send now: whole frames.
        """
        board = self.board
        board.host_baud = board.next_baud
        if self._inbox:
            data = bytes(self._inbox)
            self._inbox.clear()
            if not board.in_maintenance:
                self._handle_frames(data, board.time + dt)
        state = body.state
        board.advance(body, state, dt)
        clock = self._sip_clock
        clock.left -= dt
        if clock.left <= TOLERANCE:
            clock.renew()
            self._complete_cycle(body, state)
        if not self._outbox:
            return b""
        sent = b"".join(self._outbox)
        self._outbox.clear()
        return sent

    def _handle_frames(self, data: bytes, now: float) -> None:
        """Carry out every sound frame; damaged ones and noise are ignored."""
        for event in self._decoder.receive(data, now):
            if isinstance(event, Frame):
                self._handle(event.payload)
            if self.board.reset_due:
                self.power_cycle()
                return

    def _handle(self, payload: bytes) -> None:
        board, handshake = self.board, self._handshake
        was_open = self.connected
        answer = handshake.receive(payload)
        if answer is not None:
            self._outbox.append(encode_frame(answer))
        elif self.connected:
            board.watchdog.feed()
            if was_open:
                execute(board, payload)
            else:
                board.open()
        elif was_open:
            board.restore()

    def _complete_cycle(self, body: Body, state: BodyState) -> None:
        """Once a SIP cycle: battery, frames begun and never ended, and the packets of the cycle."""
        board = self.board
        board.consume(body, state, self._sip_clock.period)
        self._handle_frames(b"", board.time)
        if not self.connected or board.in_maintenance:
            return
        due = board.requests.take()
        for kind in AHEAD:
            if kind in due:
                self._say(EXTRAS[kind](board, state))
        self._outbox.append(encode_frame(self._codec.encode(standard_sip(board, state))))
        for kind in due:
            if kind not in AHEAD:
                self._say(EXTRAS[kind](board, state))
        for packet in answers(board):
            self._say(packet)

    def _say(self, packet: Packet) -> None:
        self._outbox.append(encode_frame(encode_packet(packet, self.board.model)))
