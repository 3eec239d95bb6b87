"""How surfaces and results show themselves in notebooks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    from henkei.io.scene import Scene


@runtime_checkable
class Shown(Protocol):
    """What says what there is to see of it."""

    def _scene_(self) -> Scene: ...


class Showing:
    """A base of what shows itself at the end of a notebook's cell, by the scene it makes."""

    def _repr_html_(self: Shown) -> str:
        """See :func:`henkei.view`; never raises."""
        from henkei.io.view import represented

        return represented(self)
