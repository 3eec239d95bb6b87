"""What was done, and can be undone and done again, without limit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from henkei.errors import InvalidInput

Document = TypeVar("Document")


@dataclass(frozen=True, eq=False)
class Step(Generic[Document]):
    """One change of a document.

    label : what was done, as in "pin vertex".
    tab : where.
    recall : gives the document after it.
    """

    label: str
    tab: str
    recall: Callable[[], Document]

    @classmethod
    def to(cls, document: Document, label: str = "", tab: str = "") -> Step[Document]:
        """The step to a document that is at hand."""
        return cls(label, tab, lambda: document)

    @property
    def document(self) -> Document:
        """The document after the step."""
        return self.recall()


class History(Generic[Document]):
    """Steps from one immutable document to the next.

    document : the one to start from.
    """

    def __init__(self, document: Document) -> None:
        self._steps = [Step.to(document)]
        self._position = 0
        self._committed = document
        self._draft: Step[Document] | None = None

    @classmethod
    def restored(cls, steps: Sequence[Step[Document]], position: int) -> History[Document]:
        """A history of steps, the first of which is the start.

        position : of the step whose document is the current one.
        """
        history = cls(steps[position].document)
        history._steps = list(steps)
        history._position = position
        return history

    @property
    def now(self) -> Document:
        """The draft if there is one, else what is committed."""
        return self._committed if self._draft is None else self._draft.document

    @property
    def committed(self) -> Document:
        """The document after the last step that is done."""
        return self._committed

    @property
    def drafted(self) -> Step[Document] | None:
        """The step that the draft would be."""
        return self._draft

    @property
    def steps(self) -> tuple[Step[Document], ...]:
        """The start, the steps that are done, and those that are undone."""
        return tuple(self._steps)

    @property
    def position(self) -> int:
        """How many steps are done."""
        return self._position

    @property
    def undo_label(self) -> str | None:
        """What :meth:`undo` would take back."""
        return self._steps[self._position].label if self._position else None

    @property
    def redo_label(self) -> str | None:
        """What :meth:`redo` would do again."""
        return self._steps[self._position + 1].label if self._undone else None

    def commit(self, document: Document, label: str, tab: str = "") -> bool:
        """Go on with a document; what was undone is lost, and so is the draft.

        An equal document is no step: then the answer is False, and only the draft is lost.
        """
        self.drop()
        if document == self._committed:
            return False
        self._steps[self._position + 1 :] = [Step.to(document, label, tab)]
        self._go(1)
        return True

    def draft(self, document: Document, label: str = "", tab: str = "") -> None:
        """Show a document that is not committed, in place of the draft before it."""
        self._draft = Step.to(document, label, tab)

    def drop(self) -> None:
        """Forget the draft."""
        self._draft = None

    def undo(self) -> Step[Document]:
        """Take back the last step, and drop the draft; the answer is that step.

        Raises
        ------
        InvalidInput : there is none.
        InvalidFile : the document before it was damaged on the disk.
        """
        if not self._position:
            raise InvalidInput("there is nothing to undo")
        step = self._steps[self._position]
        self._go(-1)
        return step

    def redo(self) -> Step[Document]:
        """Do the step again that was undone last, and drop the draft; the answer is that step.

        Raises
        ------
        InvalidInput : there is none.
        InvalidFile : the document after it was damaged on the disk.
        """
        if not self._undone:
            raise InvalidInput("there is nothing to do again")
        self._go(1)
        return self._steps[self._position]

    def let_go(self, position: int, recall: Callable[[], Document]) -> None:
        """Have the document of a step in memory only while it is asked for, by ``recall``."""
        self._steps[position] = replace(self._steps[position], recall=recall)

    @property
    def _undone(self) -> bool:
        return self._position + 1 < len(self._steps)

    def _go(self, steps: int) -> None:
        self._committed = self._steps[self._position + steps].document
        self._position += steps
        self.drop()
