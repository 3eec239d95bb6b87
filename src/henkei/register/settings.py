"""How a registration is made, beside what it is made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from henkei.errors import InvalidInput


@dataclass(frozen=True)
class Settings:
    """How a registration is made; the defaults work.

    rule : how the winner of a control point is chosen, and with it the form of the method.
        ``"nearest"``: the vertex nearest to it; both surfaces meet on the sphere, where no face is
        ever inverted. ``"literal"``: eq. 6 and 7 and algorithm 2 as printed: the vertex in front of
        the control point's plane that is nearest to that plane. That one is far away as a rule, and
        where all vertices are behind the plane there is none; faces fold, the target is hardly
        reached. For study.
    draws : control points drawn per vertex of the model, in each adaptation (T of eq. 9, divided by
        the number of vertices).
    rate_start, rate_end : how far the winner moves to the control point, as a fraction (eq. 9).
    radius_start, radius_end : how far over the mesh others follow, in edges (eq. 10).
    coarsest : vertices of the coarsest version of the model in the refinement.
    sweeps : passes over the vertices of each version of the model in the refinement.
    distortion : weight of the faces' distortion against the coverage of the target. Larger values
        keep the form of the faces, smaller ones let vertices go where the target needs them.
    guide : weight, in coarse versions, of being where alignment and landmarks let a vertex be
        expected; 0 switches it off.
    hold : weight, in all versions, of being where shapes that are alike let a vertex be
        expected; 0 switches it off.
    regions : weight of being in the region of the same label.

    Raises
    ------
    InvalidInput : a value out of range.
    """

    rule: Literal["nearest", "literal"] = "nearest"
    draws: float = 10.0
    rate_start: float = 0.3
    rate_end: float = 0.01
    radius_start: float = 2.0
    radius_end: float = 0.4
    coarsest: int = 60
    sweeps: int = 8
    distortion: float = 1e-3
    guide: float = 0.1
    hold: float = 0.005
    regions: float = 1.0

    def __post_init__(self) -> None:
        if self.rule not in ("nearest", "literal"):
            raise InvalidInput(f"rule must be 'nearest' or 'literal', not {self.rule!r}")
        for name, low, high in (
            ("draws", 0, 1e6),
            ("rate_start", 1e-300, 1),
            ("rate_end", 1e-300, 1),
            ("radius_start", 1e-3, 1e3),
            ("radius_end", 1e-3, 1e3),
            ("coarsest", 4, 1e9),
            ("sweeps", 0, 1e6),
            ("distortion", 0, 1e6),
            ("guide", 0, 1e6),
            ("hold", 0, 1e6),
            ("regions", 0, 1e6),
        ):
            value = getattr(self, name)
            kind = int if name in ("coarsest", "sweeps") else (int, float)
            if not isinstance(value, kind) or not low <= value <= high:
                raise InvalidInput(
                    f"{name} must be a number from {low:g} to {high:g}, not {value!r}"
                )
