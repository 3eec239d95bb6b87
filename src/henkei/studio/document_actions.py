"""What a person does to the document as a whole, rather than in a tab."""

from __future__ import annotations

from typing import Any, Literal, Protocol

from pydantic import ValidationError

from henkei.errors import InvalidInput
from henkei.recipes.recipe import Name, Part, reason
from henkei.studio.desk import Desk
from henkei.studio.tabs.base import MeshId

TabName = Literal["combine", "register", "deform", "quad", "design"]


class Whole(Protocol):
    """What of a session these actions use."""

    desk: Desk

    def open_example(self, name: str) -> None:
        """Begin to make a built-in example, which is then opened."""

    def restore(self, session: str) -> None:
        """Go on with an earlier session."""

    def forget(self, session: str) -> None:
        """Delete an earlier session."""

    def new(self) -> None:
        """Begin an empty session; this one is kept."""


class Show(Part):
    """Bring a tab to the front."""

    name: TabName

    def do(self, session: Whole) -> None:
        session.desk.show(self.name)


class Example(Part):
    """Open a built-in example."""

    name: Name

    def do(self, session: Whole) -> None:
        session.open_example(self.name)


class Remove(Part):
    """Close a mesh."""

    mesh: MeshId

    def do(self, session: Whole) -> None:
        session.desk.remove(self.mesh)


class Rename(Part):
    """Give a mesh another name."""

    mesh: MeshId
    name: Name

    def do(self, session: Whole) -> None:
        session.desk.rename(self.mesh, self.name)


class Keep(Part):
    """Open what a tab has made as a mesh."""

    tab: TabName
    what: Name

    def do(self, session: Whole) -> None:
        session.desk.add_product(self.tab, self.what)


class Restore(Part):
    """Go on with an earlier session."""

    session: Name

    def do(self, session: Whole) -> None:
        session.restore(self.session)


class Forget(Part):
    """Delete an earlier session."""

    session: Name

    def do(self, session: Whole) -> None:
        session.forget(self.session)


class New(Part):
    """Begin an empty session."""

    def do(self, session: Whole) -> None:
        session.new()


Act = Show | Example | Remove | Rename | Keep | Restore | Forget | New
_KINDS: dict[str, type[Act]] = {
    "show": Show,
    "example": Example,
    "remove": Remove,
    "rename": Rename,
    "keep": Keep,
    "restore": Restore,
    "forget": Forget,
    "new": New,
}


def document_action(name: Any, arguments: dict[str, Any]) -> Act:
    """The action of a name, checked.

    Raises
    ------
    InvalidInput : there is none, or an argument is missing, unknown or not usable.
    """
    if not isinstance(name, str) or name not in _KINDS:
        raise InvalidInput(f"nothing named {str(name)[:40]!r} can be done to a document")
    try:
        return _KINDS[name].model_validate(arguments)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise InvalidInput(f"{name}: {first['loc']}: {reason(first)}"[:400]) from None
