"""What is asked for, checked: how many quads and how large, by which way, from which seed."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import Any, Literal

from henkei.errors import Infeasible, InvalidInput
from henkei.geometry.arguments import is_number
from henkei.mesh import Floats, Mesh
from henkei.quad.components import Component
from henkei.quad.sizing import Density, expected_quads, relative_sizes, sizes_for

Way = Literal["auto", "field", "vsa"]

QUADS = 2000  # where nothing is said
FEWEST = 6.0  # quads that a component is made ready for
MOST = 20_000_000
TOLERATED = 1.25  # times the wished number of quads, and a few more, that are still an answer
A_FEW = 24
FINENESS = (0.5, 0.33)  # edges of the working mesh, in quad edges; the second where the first fails


@dataclass(frozen=True)
class Wish:
    """Edge lengths wished at vertices (n,), and the number of quads they make.

    strict : whether that number was asked for as such.
    """

    sizes: Floats
    quads: float
    strict: bool = False

    @classmethod
    def of(cls, mesh: Mesh, quads: Any, edge_length: Any, density: Density) -> Wish:
        """The wish for a whole surface.

        Raises
        ------
        InvalidInput : both a number and a length, or values that are none or out of range.
        """
        number = wished_quads(float(mesh.face_areas.sum()), quads, edge_length)
        relative = relative_sizes(mesh, density)
        return cls(sizes_for(mesh, relative, number), number, quads is not None)

    def within(self, component: Component) -> Wish:
        """The wish for one component."""
        sizes = self.sizes[component.vertices]
        own = expected_quads(component.mesh, sizes)
        if own < FEWEST:
            sizes, own = sizes_for(component.mesh, sizes, FEWEST), FEWEST
        return Wish(sizes, own)

    def require_met(self, made: int) -> None:
        """Raise Infeasible if there are far more quads than were asked for."""
        if self.strict and made > TOLERATED * self.quads + A_FEW:
            raise Infeasible(
                f"{self.quads:,.0f} quads were asked for, but the detail, creases and boundaries "
                f"of this surface take at least {made:,} in the best layout found; ask for that "
                "many, or leave creases out (sharp 180)"
            )


def wished_quads(area: float, quads: Any, edge_length: Any) -> float:
    """How many quads are asked for, by their number or by the length of their edges; at least 1.

    Parameters
    ----------
    area : of the surface that they are to cover.

    Raises
    ------
    InvalidInput : both a number and a length, or values that are none or out of range.
    """
    if quads is not None and edge_length is not None:
        raise InvalidInput("give quads or edge_length, not both")
    if edge_length is not None:
        if not (is_number(edge_length) and 0 < edge_length < float("inf")):
            raise InvalidInput(f"edge_length must be a positive length, not {edge_length!r}")
        number = area / float(edge_length) / float(edge_length)
        if not number <= MOST:
            raise InvalidInput(
                f"edge_length {edge_length:.3g} gives {number:.3g} quads on this surface of area "
                f"{area:.3g}; {MOST:,} are the most: give a length from {sqrt(area / MOST):.3g} on"
            )
        return max(1.0, number)
    number = QUADS if quads is None else quads
    if not (is_number(number) and number >= 1):
        raise InvalidInput(f"quads must be a number from 1, not {number!r}")
    if not number <= MOST:
        raise InvalidInput(f"quads asks for {number:.3g} quads; {MOST:,} are the most")
    return float(number)


def ways(layout: Any, patches: Any) -> list[tuple[str, float]]:
    """Layouts in the order in which they are tried, and how fine the mesh for each is.

    Raises
    ------
    InvalidInput : no such layout; a number of patches that is none, or for a layout without choice.
    """
    if layout not in ("auto", "field", "vsa"):
        raise InvalidInput(f'layout is "auto", "field" or "vsa", not {layout!r}')
    if patches is not None:
        if not is_number(patches) or not patches >= 1 or patches % 1:
            raise InvalidInput(f"patches must be a whole number from 1, not {patches!r}")
        if layout == "field":
            raise InvalidInput('the number of patches can be chosen for layout="vsa" only')
    chosen = ("field", "vsa") if layout == "auto" and patches is None else (layout,)
    chosen = ("vsa",) if patches is not None else chosen
    return [(way, fineness) for fineness in FINENESS for way in chosen]


def checked_seed(seed: Any) -> int:
    """A seed that all steps take.

    Raises
    ------
    InvalidInput : not a whole number from 0 to 2**31 - 1.
    """
    if not is_number(seed) or not 0 <= seed < 2**31 or seed % 1:
        raise InvalidInput(f"seed must be a whole number from 0 to 2,147,483,647, not {seed!r}")
    return int(seed)
