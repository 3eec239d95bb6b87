"""The document of a session: the meshes that are open, and the state of each tab."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

from pydantic import Field

from henkei.errors import InvalidInput, some
from henkei.recipes.recipe import Index, Part
from henkei.studio.register_state import RegisterState
from henkei.studio.tabs import combine, deform, design, quad, register
from henkei.studio.tabs.base import BlobId, MeshId, Tab, TabState
from henkei.studio.tabs.combine import CombineState
from henkei.studio.tabs.deform import DeformState
from henkei.studio.tabs.design import DesignState
from henkei.studio.tabs.quad import QuadState

TABS: dict[str, Tab[Any]] = {
    module.TAB.name: cast("Tab[Any]", module.TAB)
    for module in (combine, register, deform, quad, design)
}


class MeshEntry(Part):
    """An open mesh.

    surface : its blob.
    about : what it is, in a line.
    """

    id: MeshId
    name: str
    surface: BlobId
    vertices: Index
    faces: Index
    about: str = ""


class Document(Part):
    """All that is saved, done and undone. Nothing changes a document in place."""

    meshes: tuple[MeshEntry, ...] = ()
    combine: CombineState = CombineState()
    register_: RegisterState = Field(default=RegisterState(), alias="register")
    deform: DeformState = DeformState()
    quad: QuadState = QuadState()
    design: DesignState = DesignState()

    def tab(self, name: str) -> TabState:
        """The state of a tab."""
        state: TabState = getattr(self, _field(name))
        return state

    def with_tab(self, name: str, state: TabState) -> Document:
        """With another state of a tab."""
        return self.model_copy(update={_field(name): state})

    def with_entry(self, entry: MeshEntry) -> Document:
        """With one more open mesh."""
        return self.model_copy(update={"meshes": (*self.meshes, entry)})

    def without_entry(self, mesh: str) -> Document:
        """With one open mesh less."""
        left = tuple(one for one in self.meshes if one.id != mesh)
        return self.model_copy(update={"meshes": left})

    def with_name(self, mesh: str, name: str) -> Document:
        """With another name of an open mesh."""
        named = tuple(
            one.model_copy(update={"name": name}) if one.id == mesh else one for one in self.meshes
        )
        return self.model_copy(update={"meshes": named})

    def next_id(self) -> str:
        """Of the next mesh to be opened."""
        numbers = [int(one.id[1:]) for one in self.meshes]
        return f"m{max(numbers, default=0) + 1}"


def tab_named(header: Mapping[str, Any]) -> str:
    """The tab that a message or a request is for.

    Raises
    ------
    InvalidInput : there is none of that name.
    """
    tab = header.get("tab")
    if not isinstance(tab, str) or tab not in TABS:
        raise InvalidInput(f"there is no tab {str(tab)[:40]!r}; known are {some(TABS)}")
    return tab


def _field(tab: str) -> str:
    """pydantic's models have a method ``register`` of their own."""
    return "register_" if tab == "register" else tab
