"""Done, undone and done again: against a list of documents and a place in it."""

from __future__ import annotations

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from henkei.errors import InvalidFile, InvalidInput
from henkei.studio.history import History, Step

DOCUMENTS = st.integers(0, 3).map(lambda n: {"value": n})  # few, so that equal ones meet
LABELS = st.sampled_from(["move", "turn", "pin"])


class Model(RuleBasedStateMachine):
    """A history, and a plain list that says what it must be."""

    def __init__(self):
        super().__init__()
        self.history = History({"value": 0})
        self.steps = [({"value": 0}, "", "")]
        self.place = 0
        self.draft = None

    @rule(document=DOCUMENTS, label=LABELS, tab=LABELS)
    def commit(self, document, label, tab):
        is_step = document != self.steps[self.place][0]
        assert self.history.commit(document, label, tab) == is_step
        self.draft = None
        if is_step:
            self.steps = [*self.steps[: self.place + 1], (document, label, tab)]
            self.place += 1

    @rule(document=DOCUMENTS, label=LABELS)
    def try_out(self, document, label):
        self.history.draft(document, label)
        self.draft = document

    @rule()
    def drop(self):
        self.history.drop()
        self.draft = None

    @precondition(lambda self: self.place > 0)
    @rule()
    def undo(self):
        step = self.history.undo()
        assert (step.document, step.label, step.tab) == self.steps[self.place]
        self.place -= 1
        self.draft = None

    @precondition(lambda self: self.place + 1 < len(self.steps))
    @rule()
    def redo(self):
        self.place += 1
        step = self.history.redo()
        assert (step.document, step.label, step.tab) == self.steps[self.place]
        self.draft = None

    @precondition(lambda self: self.place == 0)
    @rule()
    def cannot_undo(self):
        with pytest.raises(InvalidInput, match="nothing to undo"):
            self.history.undo()

    @precondition(lambda self: self.place + 1 == len(self.steps))
    @rule()
    def cannot_redo(self):
        with pytest.raises(InvalidInput, match="nothing to do again"):
            self.history.redo()

    @invariant()
    def agrees(self):
        history, place = self.history, self.place
        assert history.committed == self.steps[place][0]
        assert history.now == (self.draft or history.committed)
        assert (history.drafted is None) == (self.draft is None)
        assert [(s.document, s.label, s.tab) for s in history.steps] == self.steps
        assert history.position == place
        assert history.undo_label == (self.steps[place][1] if place else None)
        redo = self.steps[place + 1 :]
        assert history.redo_label == (redo[0][1] if redo else None)


TestHistory = Model.TestCase
TestHistory.settings = settings(max_examples=60, stateful_step_count=40, deadline=None)


def test_there_is_no_limit_and_documents_are_shared():
    history = History(0)
    for value in range(1, 5000):
        history.commit(value, f"to {value}")
    for value in range(4999, 0, -1):
        assert history.undo().label == f"to {value}"
    assert history.now == 0
    assert history.redo_label == "to 1"


def test_the_same_object_comes_back():
    first, second = {"part": [1]}, {"part": [2]}
    history = History(first)
    history.commit(second, "change")
    history.undo()
    assert history.now is first
    history.redo()
    assert history.now is second


def test_a_document_that_cannot_be_recalled_leaves_the_history_as_it_was():
    def damaged():
        raise InvalidFile("damaged")

    steps = [Step("", "", damaged), Step("one", "a", lambda: 1), Step("two", "b", lambda: 2)]
    history = History.restored(steps, 2)
    history.undo()
    with pytest.raises(InvalidFile):
        history.undo()
    assert (history.now, history.position, history.undo_label) == (1, 1, "one")
    assert history.redo().tab == "b"
