"""`<team>/host/control`: what a team's own agents may ask of the program that holds its processes."""

import difflib
from collections.abc import Callable
from typing import Any

from acromovi.team.supervisor import Entry, Supervisor
from bus import Bus, Refused, Subscription
from bus.bus import Closeable


def control_key(team: str) -> str:
    """Where the host of a team is asked."""
    return f"{team}/host/control"


def alive_key(team: str) -> str:
    """The token that is there while a team is up."""
    return f"{team}/host/alive"


class HostControl(Closeable):
    """Answers `{"do": "status"}` and `{"do": "restart", "container": NAME}`.

    Queries come on the bus's thread; what follows from them is handed over to the supervisor's.
    """

    def __init__(self, bus: Bus, team: str, supervisor: Supervisor, hand_over: Callable[[Entry], object]) -> None:
        """Begin to answer, and show the token.

        Args:
            bus: Where to answer.
            team: The team's name.
            supervisor: Whose table it is.
            hand_over: Has a process started again, in the supervisor's event loop; called on the bus's thread.
        """
        self._team = team
        self._supervisor = supervisor
        self._hand_over = hand_over
        self._open: list[Subscription] = [
            bus.serve(control_key(team), self.answer),
            bus.declare_alive(alive_key(team)),
        ]

    def answer(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Meet one request.

        Raises:
            Refused: It asks for something else, or for a container that is not here.
        """
        match asked:
            case {"do": "status"}:
                return {"team": self._team, "processes": [entry.as_json() for entry in self._supervisor.table]}
            case {"do": "restart", "container": str(name)}:
                self._hand_over(self._container(name))
                return {"restarting": name}
        raise Refused('the host of a team takes {"do": "status"} and {"do": "restart", "container": NAME}')

    def close(self) -> None:
        """Answer no more."""
        while self._open:
            self._open.pop().close()

    def _container(self, name: str) -> Entry:
        entry = self._supervisor.container(name)
        if entry is not None:
            return entry
        known = [each.program.container for each in self._supervisor.table if each.program.container]
        near = difflib.get_close_matches(name, known, 1)
        hint = f"did you mean {near[0]!r}?" if near else f"they are {', '.join(known)}"
        raise Refused(f"there is no container {name!r} in {self._team}; {hint}")
