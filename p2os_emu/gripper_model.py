"""Dimensions and limits of a gripper, from a file of `configs/accessories`, for the world and the firmware."""

from dataclasses import dataclass

import configs
from p2os_emu.fit import Fit

PART = "gripper"


@dataclass(frozen=True, slots=True)
class GripperModel:
    """Two paddles on a lift.

    kind: as GRIPPERpac counts: 1 on the user I/O, 2 on the general I/O.
    opening_m: between open paddles. gap_m: from the front of the hull to where paddles begin.
    clearance_m: from the floor to paddles that are down. inner_beam_m, outer_beam_m: from where paddles begin.
    paddle_speed_m_s: of each paddle. paddle_friction: times an object's own is the coefficient between the two.
    contact_force_n: of one paddle, when its contact switch triggers. pressing_n_s: how the force grows while the motor
        goes on. strongest_n: where it ends.
    paddle_timeout_s, lift_timeout_s: after which the firmware calls a motion failed.
    """

    kind: int
    opening_m: float
    gap_m: float
    paddle_length_m: float
    paddle_height_m: float
    paddle_thickness_m: float
    paddle_mass_kg: float
    paddle_friction: float
    clearance_m: float
    paddle_speed_m_s: float
    inner_beam_m: float
    outer_beam_m: float
    contact_force_n: float
    pressing_n_s: float
    strongest_n: float
    lift_travel_m: float
    lift_speed_m_s: float
    lift_force_n: float
    lift_mass_kg: float
    paddle_timeout_s: float
    lift_timeout_s: float

    @property
    def reach(self) -> float:
        """Length of the paddles ahead of the hull, m."""
        return self.gap_m + self.paddle_length_m


def gripper_of(fit: Fit) -> GripperModel | None:
    """Return the gripper of a fit.

    Raises:
        ConfigError: Its file has an error.
    """
    return configs.load(GripperModel, "accessories", f"{PART}-{fit.parts[PART]}") if fit.has(PART) else None
