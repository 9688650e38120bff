"""A million packets over the radio modem with one byte in a hundred damaged: what is used, what is rejected, and why.

Nothing is estimated: every stage of the line draws by its own name, so the same stages on zeros tell which bytes were
damaged, and on positions which were lost. What the driver should make of the bytes that arrive is worked out here a
second time, with a search and a checksum of this file's own, and compared frame by frame and reason by reason.
"""

import argparse
import struct
from collections import Counter, deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import cos, inf, pi, sin, tau
from random import Random

import numpy as np
from numpy.typing import NDArray

import configs
from benchmarks.codec import READINGS
from benchmarks.figures import Figure
from gateway.driver import Driver
from gateway.events import SipReceived
from gateway.line import CABLE
from gateway.line import LineKind as GatewayLine
from gateway.settings import Settings
from p2os import (
    DecodeError,
    Frame,
    FrameDecoder,
    Identity,
    RobotHandshake,
    RobotModel,
    SipCodec,
    StandardSip,
    encode_frame,
)
from p2os.fields import POSITION_UNITS
from p2os.sip import SIP_TYPES
from p2os_emu.links.impairments import Impairments
from p2os_emu.links.line import EmulatedLine, LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.links.stage import LinkStage, Rates

PACKETS = 1_000_000
DAMAGE = 0.01  # fraction of bytes
SEED = 11
STEP = 0.04  # s; silences are whole steps, and none of them as long as a receiver waits for the rest of a frame
SIP_PERIOD = 0.1  # s
SPEED, TURN = 0.3, 0.2  # m/s and rad/s of the drive: circles
LEAVING = 0.5  # s without a byte after which everything has arrived
FIRST_CLEAN = 2.0  # s without damage in which the driver connects
PATIENCE = 0.1  # s without a byte after which a frame that was begun is given up; source: protocol sheet
SAMPLES = 20  # frames whose chance to pass the checksum is worked out
NOISE_BLOCK = 256  # bytes of noise that are counted as one
CLOSE = 0.2  # of the prediction
HIGHEST = 1.3, 2.5, 31  # wheel speed and voltage as multiples of the model's, number of a sonar disc
LATENESS = 0.35  # s that a SIP may be apart from the one before it, beyond the usual
_HEADER = 3
_RATES = Rates(9600, 9600)


@dataclass(slots=True)
class Outcome:
    """What came of the packets.

    sent: packets. intact: those that arrived without damage. used: those of them that the driver believed.
    single: packets with exactly one damaged byte; single_accepted: of these, taken for sound.
    passed: sound by their checksum and yet not what was sent; predicted: how many arithmetic expects.
    believed: those of `passed` that plausibility let through; impossible: of these, outside physical limits.
    expected, counted: bytes that were no frame, by reason; what this file finds, and what the driver counted.
    """

    sent: int = 0
    intact: int = 0
    used: int = 0
    single: int = 0
    single_accepted: int = 0
    passed: int = 0
    predicted: float = 0.0
    believed: int = 0
    impossible: int = 0
    lost_links: int = 0
    expected: Counter[str] = field(default_factory=Counter)
    counted: Counter[str] = field(default_factory=Counter)

    @property
    def miscounted(self) -> int:
        """Events by which the driver's counts differ from what was injected."""
        return sum(abs(self.expected[reason] - self.counted[reason]) for reason in self.expected | self.counted)


def measure(options: argparse.Namespace) -> list[Figure]:
    """Send the packets and compare."""
    result = run(PACKETS)
    passed, predicted = result.passed, result.predicted
    rows = (
        ("sound packets not used", result.intact - result.used, 0.0, result.intact),
        ("packets with one damaged byte taken for sound", result.single_accepted, 0.0, result.single),
        ("damaged packets that pass the checksum, off prediction", abs(passed / predicted - 1), CLOSE, passed),
        ("of these outside physical limits and on the bus", result.impossible, 0.0, passed),
        ("of these within physical limits and on the bus", result.believed - result.impossible, passed, passed),
        ("damage counted otherwise than injected", result.miscounted, 0.0, result.expected.total()),
        ("links lost", result.lost_links, 0.0, result.sent),
    )
    prefix = "radio modem, 1 % of bytes damaged"
    return [Figure("radio", f"{prefix}: {name}", float(value), float(reach), "", n) for name, value, reach, n in rows]


def run(packets: int, seed: int = SEED, samples: int = SAMPLES) -> Outcome:
    """Send so many packets over the damaged radio modem to a driver; `samples` of them give the prediction."""
    model = configs.load(RobotModel, "robots", "p3dx-sh")
    radio = configs.load(LinkProfile, "links", "radio-modem")
    radio = replace(radio, to_host=_without_bursts(replace(radio.to_host, damage=DAMAGE)))
    outcome = Outcome()
    host = _Host(model)
    truth = _Truth(radio.to_host, seed)
    account = _Account(model, host, outcome)
    link = MemoryLink(client_rate=9600)
    line = EmulatedLine(link, radio, seed)
    now = heard_at = next_sip = host.connect()
    sips = _drive(model, packets, seed)
    frame = b"?"
    while frame or now - heard_at <= LEAVING:
        now += STEP
        due = now >= next_sip
        next_sip += SIP_PERIOD * due
        frame = next(sips, b"") if due and frame else frame
        if due and frame:
            account.expect(truth.of(frame))
        line.send(frame if due else b"", now, 9600)
        if now - heard_at > PATIENCE:  # the driver gives up half a frame now, before anything else comes
            account.hear(b"", now)
            account.settle()
        heard = link.client_read()
        heard_at = now if heard else heard_at
        account.hear(heard, now)
    outcome.counted = host.driver.damaged
    outcome.lost_links = host.driver.lost.total()
    outcome.predicted = account.predicted(samples)
    return outcome


def _without_bursts(line: Impairments) -> Impairments:
    """Let as many bytes be lost one by one: bursts depend on when a byte passes, which is not drawn a second time."""
    share = line.burst_start / (line.burst_start + line.burst_end)
    return replace(line, loss=line.loss + share * line.burst_loss, burst_start=0.0)


class _Patient(Settings):
    """Never gives a robot up: of three packets two are damaged here, and now and then a whole second of them."""

    @property
    def line(self) -> GatewayLine:
        """A cable; the modem needs no dialling."""
        return replace(CABLE, sip_timeout=inf)


class _Host:
    """The gateway's driver, connected over a clean line."""

    def __init__(self, model: RobotModel) -> None:
        self.driver = Driver(lambda identity: model, (0,), _Patient(), Random(0))
        self._identity = Identity("radio", "Pioneer", model.name)
        self._model = model

    def connect(self) -> float:
        """Shake hands, and hear the first SIPs; the time then, s."""
        robot, ear, now = RobotHandshake(self._identity), FrameDecoder(), 0.0
        first = next(_drive(self._model, 1, 0))
        self.driver.port_opened(now)
        answer = b""
        while now < FIRST_CLEAN or not self.driver.is_connected:
            now += STEP
            self.driver.receive(answer, now)
            answer = first if self.driver.identity else b""
            for event in ear.receive(self.driver.bytes_due(now), now):
                if isinstance(event, Frame) and (payload := robot.receive(event.payload)) is not None:
                    answer += encode_frame(payload)
        return now

    def hear(self, data: bytes, now: float) -> list[StandardSip]:
        """Take bytes; the SIPs that go to the bus."""
        self.driver.bytes_due(now)
        return [event.sip for event in self.driver.receive(data, now) if isinstance(event, SipReceived)]


@dataclass(frozen=True, slots=True)
class _Injected:
    """A frame and what becomes of it: the places of the bytes that arrive, and what each is XORed with."""

    frame: bytes
    places: bytes
    damage: bytes

    @property
    def is_intact(self) -> bool:
        return len(self.places) == len(self.frame) and not any(self.damage)

    @property
    def has_single_error(self) -> bool:
        return len(self.places) == len(self.frame) and sum(map(bool, self.damage)) == 1


class _Truth:
    """The line's own chances, drawn a second time."""

    def __init__(self, impairments: Impairments, seed: int) -> None:
        still = replace(impairments, delay=0.0, jitter=0.0)
        name = f"{seed} host"
        self._losing = list(replace(still, bit_errors=0.0, damage=0.0).stages(name))
        self._damaging = list(replace(still, loss=0.0, burst_start=0.0).stages(name))

    def of(self, frame: bytes) -> _Injected:
        """What becomes of the next frame."""
        places = _through(self._losing, bytes(range(len(frame))))
        return _Injected(frame, places, _through(self._damaging, bytes(len(places))))


def _through(stages: Sequence[LinkStage], data: bytes) -> bytes:
    for stage in stages:
        data = stage.carry(data, 0.0, _RATES)
    return data


class _Account:
    """Compares what the driver makes of the bytes with what was injected, from one silence of the line to the next."""

    def __init__(self, model: RobotModel, host: _Host, outcome: Outcome) -> None:
        self.false_checks = 0
        self._model = model
        self._codec = SipCodec(model)
        self._host = host
        self._outcome = outcome
        self._stream = bytearray()  # what must arrive
        self._heard = 0  # bytes of it that have arrived
        self._frames: dict[int, tuple[int, _Injected]] = {}  # by place in the stream: number and frame
        self._sips: deque[StandardSip] = deque()  # that the driver published
        self._samples: list[bytes] = []
        self._last: tuple[int, StandardSip] | None = None

    def expect(self, injected: _Injected) -> None:
        """Take the next frame."""
        number = self._outcome.sent
        self._frames[len(self._stream)] = number, injected
        arriving = (injected.frame[place] for place in injected.places)
        self._stream += bytes(byte ^ damage for byte, damage in zip(arriving, injected.damage, strict=True))
        self._outcome.sent += 1
        if len(self._samples) < SAMPLES:
            self._samples.append(injected.frame)

    def hear(self, data: bytes, now: float) -> None:
        """Let the driver have what has arrived."""
        if self._stream[self._heard : self._heard + len(data)] != data:
            raise AssertionError("the line did something else to the bytes than was drawn a second time")
        self._heard += len(data)
        self._sips += self._host.hear(data, now)

    def settle(self) -> None:
        """The line is silent: work out what the driver should have found by now."""
        segment = bytes(self._stream[: self._heard])
        arrived = {place: frame for place, frame in self._frames.items() if place < self._heard}
        for place, (_, injected) in arrived.items():
            self._outcome.intact += injected.is_intact
            self._outcome.single += injected.has_single_error
            del self._frames[place]
        for place, payload in self._search(segment, arrived):
            self._take(payload, *arrived.get(place, (None, None)))
        if self._sips:
            raise AssertionError("the driver published a SIP that never was")
        del self._stream[: self._heard]
        self._frames = {place - self._heard: frame for place, frame in self._frames.items()}
        self._heard = 0

    def predicted(self, samples: int) -> float:
        """How many packets pass the checksum although they are damaged, by the chances of so many."""
        rng = sum(map(chance_to_pass, self._samples[:samples])) / min(samples, len(self._samples))
        return self._outcome.sent * rng + self.false_checks / 65536

    def _search(self, data: bytes, arrived: Mapping[int, tuple[int, _Injected]]) -> Iterator[tuple[int, bytes]]:
        """Find the frames in bytes with silence behind them: where, and the payload; count everything else."""
        expected, place, told = self._outcome.expected, 0, 0
        while (start := data.find(b"\xfa\xfb", place)) >= 0:
            expected["noise"] += -(-max(0, start - max(place, told)) // NOISE_BLOCK)
            end = start + _HEADER + data[start + 2] if start + 2 < len(data) else len(data) + 1
            place = start + 2
            if end > len(data):
                expected["partial"] += 1
                told = len(data)
            elif end < start + _HEADER + 3:
                expected["length"] += 1
                told = max(told, start + _HEADER)
            elif _sum(data[start + _HEADER : end - 2]) == int.from_bytes(data[end - 2 : end], "big"):
                yield start, data[start + _HEADER : end - 2]
                place = end
            else:
                expected["checksum"] += 1
                told = max(told, end)
                self.false_checks += start not in arrived or any(arrived[start][1].damage[:_HEADER])
        expected["noise"] += -(-max(0, len(data) - max(place, told)) // NOISE_BLOCK)

    def _take(self, payload: bytes, number: int | None, injected: _Injected | None) -> None:
        """A frame that is sound by its checksum."""
        outcome = self._outcome
        is_sent = injected is not None and injected.is_intact
        if injected is not None and injected.has_single_error:
            outcome.single_accepted += 1
        outcome.passed += not is_sent
        try:
            sip = self._codec.decode(payload) if payload[0] in SIP_TYPES else None
        except DecodeError:
            outcome.expected["content"] += 1
            return
        if sip is None or not self._sips or self._sips[0] != sip:
            return  # no SIP, or one that the driver did not believe
        self._sips.popleft()
        number = number if number is not None else self._last[0] + 1 if self._last else 0
        if is_sent:
            outcome.used += 1
        else:
            outcome.believed += 1
            outcome.impossible += self._is_impossible(sip, number)
        self._last = number, sip

    def _is_impossible(self, sip: StandardSip, number: int) -> bool:
        model = self._model
        top = HIGHEST[0] * (model.max_velocity + model.max_rotation * model.wheel_track / 2)
        if max(abs(sip.left_velocity), abs(sip.right_velocity)) > top:
            return True
        if sip.best_battery > HIGHEST[1] * model.battery_nominal or any(disc > HIGHEST[2] for disc, _ in sip.sonar):
            return True
        if self._last is None:
            return False
        before, last = self._last
        span = POSITION_UNITS * model.scales.distance
        step = max(
            abs((there - here + span / 2) % span - span / 2) for here, there in zip(last[1:3], sip[1:3], strict=True)
        )
        return step > top * ((number - before) * SIP_PERIOD + LATENESS)


def chance_to_pass(frame: bytes) -> float:
    """The chance that a frame arrives damaged behind its header and yet passes the checksum.

    The checksum adds 16-bit words, so a frame passes when the changes of its bytes add up to a multiple of 65536: those
    of high bytes count 256 times, those of the checksum against the rest; an odd last byte works on the low byte of the
    checksum. Each byte becomes one of the 255 others with a chance of `DAMAGE`. The distribution of a sum is the
    product of characteristic functions, and its value at zero their mean over all frequencies.
    """
    payload, check_low = frame[_HEADER:-2], frame[-1]
    frequencies = np.arange(65536)
    angle = tau / 65536 * frequencies
    turn = np.exp(1j * angle[1:])
    all_bytes = np.concatenate([[256.0], (1 - turn**256) / (1 - turn)])  # the sum of turn**byte over every byte

    def changed(byte: int) -> NDArray[np.complex128]:
        characteristic: NDArray[np.complex128] = (all_bytes * np.exp(-1j * angle * byte) - 1) / 255
        return characteristic

    words = len(payload) // 2
    highs = np.where(frequencies % 256 == 0, 1.0, -1 / 255)  # of a high byte: the same whatever it was
    product = ((1 - DAMAGE) + DAMAGE * highs) ** (words + 1) + 0j
    for byte, times in Counter(payload[1 : 2 * words : 2]).items():
        product *= ((1 - DAMAGE) + DAMAGE * changed(byte)) ** times
    if len(payload) % 2:
        product *= (1 - DAMAGE) + DAMAGE * changed(check_low)
    product *= (1 - DAMAGE) + DAMAGE * np.conj(changed(check_low))
    untouched = (1 - DAMAGE) ** (len(payload) + 2)
    return float((product.mean().real - untouched) * (1 - DAMAGE) ** _HEADER)


def _sum(payload: bytes) -> int:
    """The checksum, as the manuals tell it: pairs added, an odd byte XORed."""
    pairs = len(payload) // 2
    total: int = sum(struct.unpack_from(f">{pairs}H", payload)) & 0xFFFF
    return total ^ payload[-1] if len(payload) % 2 else total


def _drive(model: RobotModel, packets: int, seed: int) -> Iterator[bytes]:
    """Frames of a robot that drives in circles past things, one for each `SIP_PERIOD`."""
    codec, rng = SipCodec(model), Random(seed)
    still = codec.decode(bytes([0x33]) + bytes(31))
    radius, half_track = SPEED / TURN, model.wheel_track / 2
    for number in range(packets):
        heading = TURN * SIP_PERIOD * number % tau
        sip = still._replace(
            x=radius * sin(heading) + radius,
            y=radius * (1 - cos(heading)),
            heading=heading if heading <= pi else heading - tau,
            left_velocity=SPEED - TURN * half_track,
            right_velocity=SPEED + TURN * half_track,
            battery=12.6,
            battery_fine=12.6,
            flags=3,
            sonar=tuple((rng.randrange(16), rng.uniform(0.2, 5.0)) for _ in range(READINGS)),
        )
        yield encode_frame(codec.encode(sip))
