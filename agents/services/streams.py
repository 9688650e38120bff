"""The state of the streams that are watched. No bus, no clock."""

from collections.abc import Callable

from agents.platform import AgentName
from agents.services.events import Level, Standing
from agents.services.pulse import Beat, Pulse
from bus import keys

Tell = Callable[[object, str, Level], None]


class StreamPulses:
    """The pulses of all watched streams, by their keys."""

    def __init__(self, tell: Tell) -> None:
        self._tell = tell
        self._pulses: dict[str, Pulse] = {}

    @property
    def keys(self) -> list[str]:
        """The watched keys."""
        return list(self._pulses)

    def watch(self, key: str, now: float, declared: float | None = None) -> None:
        """Start watching a stream; `declared` is its rate in Hz, if it is known."""
        self._pulses.setdefault(key, Pulse(now, declared))

    def ignore(self, key: str) -> None:
        """Stop watching a stream."""
        self._pulses.pop(key, None)

    def beat(self, key: str, now: float) -> None:
        """Count a sample; on any thread."""
        pulse = self._pulses.get(key)
        if pulse is not None:
            pulse.beat(now)

    def judge(self, now: float, is_excused: Callable[[str], bool]) -> None:
        """Update all states, and report changes; streams that are excused have a reason to be silent."""
        for key, pulse in self._pulses.items():
            if is_excused(key):
                pulse.excuse(now)
                continue
            before = pulse.state
            if pulse.judge(now) and not (before is Beat.LEARNING and pulse.state is Beat.STEADY):
                self._tell(_maker(key), _sentence(key, pulse, now), _level(pulse))

    def standings(self, now: float, robot: str | None = None) -> list[Standing]:
        """Return the state of each, or of each one of a robot."""
        return [
            Standing(
                key,
                _level(pulse),
                _sentence(key, pulse, now),
                {"rate": round(pulse.rate, 2), "usual": None if pulse.usual is None else round(pulse.usual, 2)},
            )
            for key, pulse in self._pulses.items()
            if robot is None or keys.split(key)[0] == robot
        ]


LEVELS = {Beat.SLOW: Level.WARNING, Beat.SILENT: Level.ERROR}  # all else is well


def _maker(key: str) -> str:
    """Return the publisher of a stream: an agent or a robot."""
    robot, suffix = keys.split(key)
    return str(AgentName.of_key(key)) if suffix.startswith("agents/") else robot


def _level(pulse: Pulse) -> Level:
    return LEVELS.get(pulse.state, Level.OK)


def _sentence(key: str, pulse: Pulse, now: float) -> str:
    usual = f"{pulse.usual:.3g} Hz" if pulse.usual is not None else "nothing"
    match pulse.state:
        case Beat.SILENT:
            return f"{key} has been silent for {pulse.silence(now):.1f} s, where {usual} are usual"
        case Beat.SLOW:
            return f"{key} comes with {pulse.rate:.3g} Hz, where {usual} are usual"
        case Beat.LEARNING:
            return f"{key} has not come often enough to know its rate"
        case Beat.RESTING:
            return f"{key} rests, for a reason that has been told"
    return f"{key} flows"
