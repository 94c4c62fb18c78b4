"""Compensators written in Python.

A compensator is made for each axis by a callable that takes :class:`AxisFacts`, and has a method
``step``, which is called once a servo tick (250 us of machine time, some microseconds of yours).
That makes a run many times slower than with a registered method: it is for trying ideas. A method
that has proved itself is written in Rust (``lostmotion::drive::Compensator``), at full speed.

All angles are rad at the motor's shaft.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from ._native import Tick

__all__ = ["AxisFacts", "Compensator", "CompensatorMaker", "Correction"]


@dataclass(frozen=True)
class AxisFacts:
    """What is known of an axis; the load is as the motor's shaft sees it."""

    unit: str
    """Unit of the axis: ``mm``, ``deg`` or ``rad``."""
    motor_rad_per_unit: float
    """Radian of the motor for one unit of the axis."""
    servo_period_s: float
    """Time between two calls of ``step``, s."""
    gap_rad: float
    """Total gap, rad."""
    motor_inertia_kgm2: float
    """Inertia on the motor's side of the gap, kg m2."""
    motor_coulomb_nm: float
    """Coulomb friction of the motor, N m."""
    load_inertia_kgm2: float
    """Inertia of the load, kg m2."""
    load_coulomb_nm: float
    """Coulomb friction of the load, N m."""
    load_viscous_nm_s_per_rad: float
    """Viscous friction of the load, N m s/rad."""
    load_constant_nm: float
    """Constant torque against the positive direction, N m."""
    stiffness_nm_per_rad: float
    """Stiffness of the shaft, N m/rad."""
    damping_nm_s_per_rad: float
    """Damping of the shaft, N m s/rad."""
    description: Mapping[str, Any]
    """Everything in the axis' table of the machine file."""


@dataclass(frozen=True)
class Correction:
    """What a compensator adds at a servo tick."""

    position: float = 0.0
    """Added to the position reference, rad."""
    velocity: float = 0.0
    """Added to the velocity feed-forward, rad/s."""
    torque: float = 0.0
    """Added to the torque feed-forward, N m."""
    feedback: float = 0.0
    """Subtracted from the measured motor position, rad."""

    def __post_init__(self) -> None:
        for name in ("position", "velocity", "torque", "feedback"):
            if not math.isfinite(getattr(self, name)):
                raise ValueError(f"{name} is {getattr(self, name)}; it has to be finite")


class Compensator(Protocol):
    """One axis' compensator.

    It may also have ``start(motor_position)``, called once with the motor's place at the start,
    rad. Runs may copy it (``copy.deepcopy``) to look ahead. Where it declares
    ``load_scale = True`` on its maker, ``signals.load_position`` is the load's scale.
    """

    def step(self, signals: Tick, /) -> Correction | float | None:
        """One servo tick; a number is a correction of the position, nothing is none."""


class CompensatorMaker(Protocol):
    """Makes the compensator of an axis: a class that takes the facts, or a function."""

    def __call__(self, facts: AxisFacts, /) -> Compensator: ...
