"""A session: one document, what is done to it, and the pages that look at it.

All of it runs on one thread, the engine's, so that nothing needs a lock; what happens elsewhere,
in jobs and uploads, is posted to that thread.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from queue import SimpleQueue
from threading import Timer
from typing import Any

from henkei.errors import HenkeiError, InvalidInput
from henkei.progress import silent
from henkei.studio import examples
from henkei.studio.aside import Aside
from henkei.studio.desk import Desk
from henkei.studio.document import TABS, Document, tab_named
from henkei.studio.document_actions import document_action
from henkei.studio.downloads import clear_old
from henkei.studio.jobs import Done, Outcome
from henkei.studio.messages import Message, arguments_of
from henkei.studio.pages import Client, EngineProgress, Pages
from henkei.studio.services import Services
from henkei.studio.sessions import Kept, Sessions
from henkei.studio.tabs.base import Action, LongAction, Work
from henkei.studio.works import DOWNLOADS, Post, Works, reason

TIDY_AFTER = 30.0  # seconds after the start

BROKEN = (
    "this failed inside henkei, which is a fault of ours. Nothing was changed; please report it "
    "with what the terminal says"
)
_LOG = logging.getLogger(__name__)


class Session:
    """One document and its pages.

    Parameters
    ----------
    folder : where sessions and blobs are kept.
    post : runs something on this session's thread, later.
    """

    def __init__(self, folder: Path, post: Post) -> None:
        self._post = post
        self._sessions = sessions = Sessions(
            Document(),
            dump=lambda document: document.model_dump(mode="json"),
            load=Document.model_validate,
            folder=folder,
        )
        self._services = Services(sessions.blobs)
        self._pages = Pages(self._services)
        self._services.tell = lambda message: self._notice("info", message)
        self._services.aside = self._aside = Aside(self._later, self._pages.tell)
        self._services.renew = self._renew
        self._works = Works(sessions.folder, sessions.blobs.folder, self._later, self._pages.tell)
        self._progress = EngineProgress(self._pages.tell)
        self._done: deque[Any] = deque(maxlen=1000)  # ids of messages
        self._names: dict[Client, Any] = {}  # what pages call themselves
        self._dragger: Any = None  # the name of the page that tried something out last
        self.desk = Desk(sessions.create(), self._services, self._publish)
        self._tidying = Timer(TIDY_AFTER, self._tidy)
        self._tidying.daemon = True
        self._tidying.start()

    # From pages

    def connected(self, client: Client) -> None:
        """A page has come; it is told everything once it says hello."""
        self._names[client] = client
        self._pages.add(client)

    def disconnected(self, client: Client) -> None:
        """A page has gone; what it was dragging is kept."""
        self._names.pop(client, None)
        self._pages.remove(client)

    def receive(self, client: Client, message: Message) -> None:
        """Do what a page asks for, and answer it."""
        answers: dict[str, Callable[[Client, Message], None]] = {
            "hello": self._hello,
            "do": self._do,
            "grab": self._grab,
            "drop": self._drop,
            "undo": self._undo,
            "redo": self._redo,
            "cancel": self._cancel,
        }
        ident = message.header.get("id")
        with self._answering(client, ident):
            if ident in self._done:  # asked again by a page that lost the answer
                client.send({"kind": "done", "id": ident, "revision": self._pages.revision})
                return
            if message.kind not in answers:
                raise InvalidInput(f"there is no message of kind {message.kind[:40]!r}")
            answers[message.kind](client, message)
            if ident is not None:
                self._done.append(ident)
                client.send({"kind": "done", "id": ident, "revision": self._pages.revision})

    def live(self, client: Client, message: Message) -> None:
        """Try an action on what was committed last, for the picture; a crash does not lose it."""
        with self._answering(client, None):
            arguments = arguments_of(message)
            blended = arguments.pop("blended", False)  # by this page, which wants no positions
            tab, action = self._action(message, arguments)
            if isinstance(action, LongAction):
                raise InvalidInput("long work is not done while dragging")
            self.desk.try_out(tab, action)
            self._dragger = self._names.get(client)
            self._pages.show_positions(
                self.desk.now,
                tab,
                exact=False,
                sequence=message.header.get("sequence"),
                but=client if blended else None,
            )

    # From files, examples and other threads

    def open(self, path: Path) -> None:
        """Open a file of the person who started the studio."""

        def ended(outcome: Outcome) -> None:
            if isinstance(outcome, Done):
                self.desk.add(**outcome.result)
            else:
                self._notice("error", reason(outcome))

        self._works.read(path, path.name, ended, alone=False)

    def uploaded(self, path: Path, name: str) -> dict[str, Any]:
        """Open a file from a page, and wait for it; called on a thread for uploads."""
        answers: SimpleQueue[dict[str, Any]] = SimpleQueue()
        is_recipe = name.lower().endswith(".json")

        def ended(outcome: Outcome) -> None:
            answer = {"message": BROKEN}
            try:
                if not isinstance(outcome, Done):
                    answer = {"message": reason(outcome) or "cancelled"}
                elif is_recipe:
                    self.desk.take_recipe(outcome.result["tab"], outcome.result["recipe"])
                    answer = {"recipe": outcome.result["tab"]}
                else:
                    answer = {"mesh": self.desk.add(**outcome.result)}
            except HenkeiError as error:
                answer = {"message": str(error)}
            finally:
                answers.put(answer)

        if is_recipe:
            self._works.read_recipe(path, name, ended)
        else:
            self._works.read(path, name, ended, alone=True)
        return answers.get()

    def export(self, request: dict[str, Any]) -> dict[str, Any]:
        """Begin to write what a tab has as a file; see :mod:`henkei.studio.exports`."""
        try:
            tab = tab_named(request)
            state: Any = self.desk.committed.tab(tab)
            entries = {slot: self._services.entry(mesh) for slot, mesh in state.meshes.items()}
        except HenkeiError as error:
            return {"message": str(error)}
        asked = {
            "format": request.get("format"),
            "options": request.get("options", {}),
            "recipe": state.recipe.model_dump(mode="json", exclude_defaults=True),
            "meshes": {slot: (entry.name, entry.surface) for slot, entry in entries.items()},
            "result": state.made,
        }
        return self._works.write(tab, asked)

    def download(self, ident: str) -> tuple[Path, str] | None:
        """A file that was exported, and its name."""
        return self._works.written(ident)

    def data(self, blob: str) -> Path | None:
        """The file of a blob; None if there is none."""
        try:
            return self._services.blobs.path(blob)
        except HenkeiError:
            return None

    def close(self) -> None:
        """The studio ends; what is open is kept."""
        self._tidying.cancel()
        self._services.forget()
        self._aside.close()
        self._works.close()
        self.desk.kept.close()

    # What is done to the document as a whole

    def open_example(self, name: str) -> None:
        """Begin to make a built-in example; once that is done, its meshes and recipe are open."""
        example = examples.example(name)

        def ended(outcome: Outcome) -> None:
            if isinstance(outcome, Done):
                self.desk.take_example(example, **outcome.result)
            else:
                self._publish()

        work = Work("henkei.studio.tasks.example:run", {"name": name}, f"Open {example.title}")
        if not self._works.is_going_on(example.tab, work):
            self._works.start(example.tab, work, ended, self._pages.show_surface)

    def restore(self, session: str) -> None:
        """Go on with an earlier session; the present one is kept."""
        self._switch(self._sessions.open(session))

    def forget(self, session: str) -> None:
        """Delete an earlier session."""
        self._sessions.forget(session)
        self._publish()

    def new(self) -> None:
        """Begin an empty session; the present one is kept."""
        self._switch(self._sessions.create())

    # How it is done

    def _hello(self, client: Client, message: Message) -> None:
        name, wanted = message.header.get("page"), message.header.get("session")
        self._names[client] = name if isinstance(name, str) else client
        self._keep_left()
        known = {offer.id for offer in self._sessions.offers()}
        if isinstance(wanted, str) and wanted in known and not self.desk.now.meshes:
            self._switch(self._sessions.open(wanted))
        else:
            self._pages.add(client)
            self._publish()

    def _keep_left(self) -> None:
        """What a page was trying out that has gone is done; it may come back by its name."""
        left = self.desk.kept.history.drafted
        if left is not None and self._dragger not in self._names.values():
            self.desk.kept.commit(left.document, left.label, left.tab)

    def _settle(self) -> None:
        """No drag goes on."""
        for tab in TABS.values():
            tab.settle(self._services)

    def _do(self, client: Client, message: Message) -> None:
        self._keep_left()
        if message.header.get("tab") == "document":
            document_action(message.header.get("action"), arguments_of(message)).do(self)
            return
        tab, action = self._action(message, arguments_of(message))
        TABS[tab].settle(self._services)
        if isinstance(action, LongAction):
            self._start(tab, action)
        else:
            self.desk.do(tab, action)

    def _action(self, message: Message, arguments: dict[str, Any]) -> tuple[str, Action[Any]]:
        tab = tab_named(message.header)
        return tab, TABS[tab].action(message.header.get("action"), arguments)

    def _grab(self, client: Client, message: Message) -> None:
        """A drag begins: if the surface answers it linearly, the page can do without frames."""
        tab = tab_named(message.header)
        asked, state = arguments_of(message), self.desk.committed.tab(tab)
        basis = TABS[tab].basis(state, asked, self._services)
        if basis is not None:
            self._pages.send_basis(client, tab, basis, asked)

    def _drop(self, client: Client, message: Message) -> None:
        self._keep_left()
        self.desk.kept.drop()
        self._settle()
        self._publish()

    def _undo(self, client: Client, message: Message) -> None:
        self._keep_left()
        self._settle()
        self.desk.undo()

    def _redo(self, client: Client, message: Message) -> None:
        self._keep_left()
        self._settle()
        self.desk.redo()

    def _switch(self, kept: Kept[Document]) -> None:
        """Go on with another document."""
        if kept is not self.desk.kept:
            self.desk.kept.close()
        self._works.abandon()
        self.desk = Desk(kept, self._services, self._publish, self.desk.tab)
        self._done.extend(kept.asked)
        self._services.forget()
        self._pages.forget()
        if kept.damage:
            self._services.tell(kept.damage)
        self._publish()

    def _start(self, tab: str, action: LongAction[Any]) -> None:
        """Begin long work; when it is done, its result goes into the state as it is then.

        Unless other meshes were chosen meanwhile; the id of one that was closed is used again.
        """
        begun_with = self.desk.surfaces(tab)

        def ended(outcome: Outcome) -> None:
            if isinstance(outcome, Done) and self.desk.surfaces(tab) == begun_with:
                state = action.finished(self.desk.committed.tab(tab), outcome.result)
                self.desk.take(tab, state, action.label)
            else:
                self._publish()

        work = action.work(self.desk.committed.tab(tab), self._services)
        if self._works.is_going_on(tab, work):
            return
        self._works.start(tab, work, ended, self._pages.show_surface)

    def _cancel(self, client: Client, message: Message) -> None:
        self._works.cancel(str(message.header.get("job")))

    def _publish(self) -> None:
        """Tell all pages what is now."""
        kept, now = self.desk.kept, self.desk.now
        history = kept.history
        self._services.meshes = now.meshes
        header = {
            "session": kept.id,
            "undo": history.undo_label,
            "redo": history.redo_label,
            "jobs": self._works.listed,
            "exported": self._works.exported,
            "offers": [] if now.meshes else self._sessions.listed(but=kept.id),
            "examples": examples.listed(),
        }
        self._pages.publish(now, self.desk.tab, header)
        if kept.trouble:
            self._notice("warning", kept.trouble)

    def _renew(self, tab: str) -> None:
        """Tell what of a tab is another now though nothing was done."""
        self._pages.renew(tab)
        self._publish()

    def _tidy(self) -> None:
        """Remove what nobody needs any more; on a thread of its own."""
        with suppress(OSError):
            self._sessions.tidy()
            clear_old(self._sessions.folder / DOWNLOADS)

    def _notice(self, level: str, message: str) -> None:
        self._pages.tell({"kind": "notice", "level": level, "message": message})

    def _later(self, work: Callable[[], None]) -> None:
        """Have something done on the session's thread that no page waits for."""

        def done() -> None:
            with self._answering(None, None):
                work()

        self._post(done)

    @contextmanager
    def _answering(self, client: Client | None, ident: Any) -> Iterator[None]:
        """Answer what goes wrong, to all pages if none asked; show progress of what takes long."""

        def refuse(message: str) -> None:
            if client is None:
                self._notice("error", message)
            else:
                client.send({"kind": "refused", "id": ident, "message": message})

        self._services.progress = self._progress = EngineProgress(self._pages.tell)
        self.desk.asked = ident
        try:
            yield
        except HenkeiError as error:
            refuse(str(error))
        except Exception:
            _LOG.exception("something failed")
            refuse(BROKEN)
        finally:
            self._services.progress = silent
            self.desk.asked = None
            self._progress.end()
