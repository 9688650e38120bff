"""Which followers are lost, why, and when they are back."""

import math
from collections.abc import Mapping, Sequence

from apps.formation.members import Member, MemberState
from apps.formation.settings import FormationSettings

ROLLS, TURNS = 0.02, 0.08  # m/s and rad/s; what is slower stands
HAS_WAY = 0.15  # m from its point from which a follower is expected to move
BACK_AFTER = 1.0  # s for which a follower that was stuck has to move
STUCK, ON_ITS_WAY = "does not move", "is on its way back"


class Membership:
    """The followers by name, and what is told of them.

    followers: by name. told: sentences since the last time that somebody emptied it.
    """

    def __init__(self, names: Sequence[str], settings: FormationSettings, unheard: str = "is silent") -> None:
        """Begin with all. unheard: what is told of a robot without a recent state."""
        self.followers = {name: Member(name) for name in names}
        self.told: list[str] = []
        self._limits = settings.members
        self._unheard = unheard
        self._silence = settings.safety.silent_s

    @property
    def active(self) -> list[str]:
        """The followers that are not lost."""
        return [name for name, member in self.followers.items() if not member.trouble]

    @property
    def lost(self) -> list[Member]:
        """The followers that are."""
        return [member for member in self.followers.values() if member.trouble]

    def is_silent(self, state: MemberState, now: float) -> bool:
        """Return whether a robot has not been heard of for too long; `now` in s."""
        return now - state.heard > self._silence

    def can_be_driven(self, name: str, states: Mapping[str, MemberState], now: float) -> bool:
        """Return whether a follower is heard, has no trouble, and does not refuse."""
        if name not in states or self.followers[name].refusal or states[name].trouble:
            return False
        return not self.is_silent(states[name], now)

    def judge_hearing(self, now: float, states: Mapping[str, MemberState]) -> None:
        """Find out which followers cannot be driven."""
        for name, member in self.followers.items():
            if name not in states or self.is_silent(states[name], now):
                self._lose(member, self._unheard)
            elif states[name].trouble:
                self._lose(member, states[name].trouble)
            elif member.refusal:
                self._lose(member, f"refuses to drive: {member.refusal}")
            elif member.trouble and member.trouble != STUCK:
                member.trouble = ON_ITS_WAY

    def judge_motion(
        self, now: float, states: Mapping[str, MemberState], errors: Mapping[str, float], all_wait: bool
    ) -> bool:
        """Find out which followers are stuck or too far away, and which are back.

        Args:
            now: s.
            states: Of all robots.
            errors: Distance of each follower from its point, m.
            all_wait: Whether followers stand because they are told to.
        Returns:
            Whether one is back.
        """
        is_one_back = False
        for name, error in errors.items():
            member, twist = self.followers[name], states[name].twist
            moves = abs(twist.linear) > ROLLS or abs(twist.angular) > TURNS
            if member.trouble:
                if self._is_back(member, moves, error, now):
                    self.told.append(f"{name} is back")
                    member.trouble, member.busy_at, member.near_at = "", now, now
                    is_one_back = True
                continue
            is_new = member.busy_at == -math.inf
            if is_new or moves or error < HAS_WAY or all_wait:
                member.busy_at = now
            if is_new or error < self._limits.lost_m:
                member.near_at = now
            if now - member.busy_at > self._limits.stuck_s:
                self._lose(member, STUCK)
                member.busy_at = math.inf
            elif now - member.near_at > self._limits.stuck_s:
                self._lose(member, f"is {error:.1f} m from its place")
        return is_one_back

    def _is_back(self, member: Member, moves: bool, error: float, now: float) -> bool:
        """Return whether a lost follower is a member again: near its place, and driving if it was stuck."""
        if member.refusal:
            return False
        if member.trouble == STUCK:
            member.busy_at = min(member.busy_at, now) if moves else math.inf
            if now - member.busy_at < BACK_AFTER:
                return False
            member.trouble = ON_ITS_WAY
        return self._limits.when_stopped == "wait" or error < self._limits.back_m

    def _lose(self, member: Member, why: str) -> None:
        if not member.trouble:
            act = "all wait for it" if self._limits.when_stopped == "wait" else "the others close the gap"
            self.told.append(f"{member.name} {why}; {act}")
        member.trouble = why
