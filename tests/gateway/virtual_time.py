"""What benches under a virtual clock have in common."""

from abc import ABC, abstractmethod
from collections.abc import Callable


class VirtualTime(ABC):
    """now: steady time of everything on the bench, s."""

    now: float

    @abstractmethod
    def step(self) -> None:
        """Let one step pass."""

    def run(self, seconds: float, each: Callable[[], None] | None = None) -> None:
        """Let time pass; `each` is called after every step."""
        end = self.now + seconds
        while self.now < end - 1e-9:
            self.step()
            if each is not None:
                each()

    def run_until(self, condition: Callable[[], bool], limit: float = 20.0) -> float:
        """Let time pass until something is so; return how long it took, s."""
        start = self.now
        while not condition():
            assert self.now - start < limit, "it did not happen"
            self.step()
        return self.now - start
