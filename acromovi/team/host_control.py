"""`<team>/host/control`: requests of a team's agents to the program that runs its processes."""

import difflib
from typing import Any, Protocol

from acromovi.team.supervisor import ProcessRow, Supervisor
from bus import Bus, KeyNotValid, Refused, Subscription
from bus.bus import Closeable

MOST_EXTRAS = 32  # containers that others may ask for


class _ProcessCommands(Protocol):
    """Commands for processes, carried out later in the supervisor's event loop; called on the bus's thread."""

    def restart(self, entry: ProcessRow) -> None:
        """Restart a process."""

    def start(self, container: str) -> None:
        """Start an empty container, in addition to those of the team."""

    def retire(self, entry: ProcessRow) -> None:
        """End such a container and do not restart it."""


class HostControl(Closeable):
    """Answers `{"do": "status"}`, and `restart`, `start` and `end` with `"container": NAME`.

    `start` and `end` are for containers that the team does not have by itself, in which its loader puts applications.
    Queries come on the bus's thread; what follows from them is handed over to the supervisor's.
    """

    def __init__(self, bus: Bus, team: str, supervisor: Supervisor, hands: _ProcessCommands) -> None:
        """Begin to answer, and show the token.

        Args:
            bus: Where to answer.
            team: The team's name.
            supervisor: Whose table it is.
            hands: Do it.
        """
        self._team = team
        self._supervisor = supervisor
        self._hands = hands
        self._open: list[Subscription] = [
            bus.serve(self.key(team), self.answer),
            bus.declare_alive(self.alive_key(team)),
        ]

    @staticmethod
    def key(team: str) -> str:
        """Return the key for requests to the host of a team."""
        return f"{team}/host/control"

    @staticmethod
    def alive_key(team: str) -> str:
        """Return the key of the token that exists while a team runs."""
        return f"{team}/host/alive"

    def answer(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Carry out one request.

        Raises:
            Refused: It asks for something else, or for a container that is not here.
        """
        match asked:
            case {"do": "status"}:
                return {"team": self._team, "processes": [entry.as_json() for entry in self._supervisor.table]}
            case {"do": "restart", "container": str(name)}:
                self._hands.restart(self._container(name))
                return {"restarting": name}
            case {"do": "start", "container": str(name)}:
                self._start(name)
                return {"starting": name}
            case {"do": "end", "container": str(name)}:
                self._hands.retire(self._extra(name))
                return {"ending": name}
        raise Refused('the host of a team takes {"do": "status"}, and restart, start or end with {"container": NAME}')

    def close(self) -> None:
        """Stop answering."""
        while self._open:
            self._open.pop().close()

    def _start(self, name: str) -> None:
        there = self._supervisor.container(name)
        if there is not None and there.program.is_extra:
            return
        if there is not None:
            raise Refused(f"{there.program.name} is one of {self._team} itself; take another name")
        if sum(entry.program.is_extra for entry in self._supervisor.table) >= MOST_EXTRAS:
            raise Refused(f"the host of {self._team} has {MOST_EXTRAS} containers for applications, and starts no more")
        try:
            self._hands.start(name)
        except KeyNotValid as err:
            raise Refused(str(err)) from err

    def _extra(self, name: str) -> ProcessRow:
        entry = self._container(name)
        if not entry.program.is_extra:
            raise Refused(f"{entry.program.name} is one of {self._team} itself, and ends with it")
        return entry

    def _container(self, name: str) -> ProcessRow:
        entry = self._supervisor.container(name)
        if entry is not None:
            return entry
        known = [each.program.container for each in self._supervisor.table if each.program.container]
        near = difflib.get_close_matches(name, known, 1)
        hint = f"did you mean {near[0]!r}?" if near else f"they are {', '.join(known)}"
        raise Refused(f"there is no container {name!r} in {self._team}; {hint}")
