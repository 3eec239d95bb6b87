"""What is on the desk: one document, what is done to it, and where its steps are kept."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from henkei.studio.document import TABS, Document, MeshEntry
from henkei.studio.examples import Example
from henkei.studio.services import Services
from henkei.studio.sessions import Kept
from henkei.studio.tabs.base import Action


class Desk:
    """A document, changed step by step.

    Parameters
    ----------
    kept : where its steps are.
    services : what tabs work with.
    changed : called after each step.
    tab : in front, if no step tells.

    Attributes
    ----------
    tab : the one in front.
    asked : the id of the message that is being answered; its steps remember it.
    """

    def __init__(
        self,
        kept: Kept[Document],
        services: Services,
        changed: Callable[[], None],
        tab: str = "combine",
    ) -> None:
        self.kept, self._services, self._changed = kept, services, changed
        steps = reversed(kept.history.steps[: kept.history.position + 1])
        self.tab = next((step.tab for step in steps if step.tab in TABS), tab)
        self.asked: Any = None

    @property
    def now(self) -> Document:
        """With what is being tried out."""
        document: Document = self.kept.history.now
        return document

    @property
    def committed(self) -> Document:
        """What everything that is done begins from."""
        document: Document = self.kept.history.committed
        return document

    def surfaces(self, tab: str) -> list[str | None]:
        """The blobs of the meshes in a tab's slots."""
        known = {entry.id: entry.surface for entry in self.committed.meshes}
        return [known.get(mesh or "") for mesh in self.committed.tab(tab).meshes.values()]

    # In a tab

    def try_out(self, tab: str, action: Action[Any]) -> None:
        """Do an action to what was committed last, and commit nothing."""
        state = action.apply(self.committed.tab(tab), self._services)
        self.kept.draft(self.committed.with_tab(tab, state), action.label, tab)

    def do(self, tab: str, action: Action[Any]) -> None:
        """Do an action."""
        self.take(tab, action.apply(self.committed.tab(tab), self._services), action.label)

    def take(self, tab: str, state: Any, label: str) -> None:
        """Another state of a tab is the next step."""
        self._commit(self.committed.with_tab(tab, state), label, tab)

    def undo(self) -> None:
        """Go a step back, and to the tab that it was in."""
        self._step(self.kept.undo(self.asked).tab)

    def redo(self) -> None:
        """Do again what was undone."""
        self._step(self.kept.redo(self.asked).tab)

    # To the document as a whole

    def show(self, tab: str) -> None:
        """Bring a tab to the front; where it has no mesh yet, with those that are open.

        Not while something was undone, which could not be done again after that.
        """
        self.tab = tab
        undone = self.kept.history.redo_label is not None
        state = self.committed.tab(tab) if undone else self._filled(tab)
        self.take(tab, state, "choose mesh")

    def add(self, **mesh: Any) -> str:
        """Open a mesh, of the fields of its entry; it goes into a free slot of the tab in front."""
        document = self.committed
        entry = MeshEntry(id=document.next_id(), **mesh)
        document = document.with_entry(entry)
        state = document.tab(self.tab)
        free = [slot for slot, used in state.meshes.items() if used is None]
        if free:
            document = document.with_tab(self.tab, state.with_mesh(free[0], entry.id))
        self._commit(document, f"open {entry.name}", self.tab)
        return entry.id

    def add_product(self, tab: str, what: str) -> None:
        """Open what a tab has made as a mesh."""
        self.add(**asdict(TABS[tab].product(self.committed.tab(tab), what, self._services)))

    def remove(self, mesh: str) -> None:
        """Close a mesh; tabs that it was in have none then."""
        document, entry = self.committed, self._services.entry(mesh)
        document = document.without_entry(mesh)
        for tab in TABS:
            for slot, used in document.tab(tab).meshes.items():
                if used == mesh:
                    document = document.with_tab(tab, document.tab(tab).with_mesh(slot, None))
        self._commit(document, f"close {entry.name}", self.tab)

    def rename(self, mesh: str, name: str) -> None:
        """Give a mesh another name."""
        self._services.entry(mesh)
        self._commit(self.committed.with_name(mesh, name), "rename mesh", self.tab)

    def take_recipe(self, tab: str, recipe: dict[str, Any]) -> None:
        """Give a recipe to the tab that it is for, whose meshes are open."""
        action = TABS[tab].action("load", {"recipe": recipe})
        state = action.apply(self._filled(tab), self._services)
        self.tab = tab
        self.take(tab, state, "open recipe")

    def take_example(
        self, example: Example, meshes: list[dict[str, Any]], recipe: dict[str, Any]
    ) -> None:
        """Open meshes in the slots of a tab, and a recipe, in one step."""
        tab, document = example.tab, self.committed
        state = document.tab(tab)
        for slot, mesh in zip(state.slots, meshes, strict=True):
            entry = MeshEntry(id=document.next_id(), **mesh)
            document, state = document.with_entry(entry), state.with_mesh(slot, entry.id)
        self.tab = tab
        self._services.meshes = document.meshes
        state = TABS[tab].action("load", {"recipe": recipe}).apply(state, self._services)
        self._commit(document.with_tab(tab, state), f"open {example.name}", tab)

    def _filled(self, tab: str) -> Any:
        """The state of a tab; if it has no mesh yet, with those that are open."""
        state = self.committed.tab(tab)
        if not any(state.meshes.values()):
            for slot, entry in zip(state.slots, self.committed.meshes, strict=False):
                state = state.with_mesh(slot, entry.id)
        return state

    def _commit(self, document: Document, label: str, tab: str) -> None:
        self.kept.commit(document, label, tab, self.asked)
        self._changed()

    def _step(self, tab: str) -> None:
        """Show what was done or undone, where it was."""
        self.tab = tab or self.tab
        self._changed()
