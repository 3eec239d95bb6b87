"""A studio and its page in headless Chromium, for the tests of the page.

``studio`` : a running studio with a folder of its own, one for the tests of a module.
``page`` : a :class:`driven.Driven` with an empty session; errors of the page fail the test.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from driven import CHROMIUM, FLAGS, Driven, RunningStudio, studio_running
from henkei.errors import MissingDependency
from henkei.io.page import page_folder

if TYPE_CHECKING:
    from playwright.sync_api import Browser

SIZE = (1180, 760)  # pixels of the page; each costs time where there is no graphics card


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Chromium, without a window."""
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="the page is tested with Playwright: pip install playwright"
    )
    if not CHROMIUM.exists():
        pytest.skip(f"the page is tested in Chromium, which is not there: {CHROMIUM}")
    try:
        page_folder()
    except MissingDependency as error:
        pytest.skip(f"the page is not built: {error}")
    with playwright.sync_playwright() as running:
        chromium = running.chromium.launch(executable_path=str(CHROMIUM), args=FLAGS)
        yield chromium
        chromium.close()


@pytest.fixture(scope="module")
def studio(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningStudio]:
    """``henkei studio`` on a free port."""
    with studio_running(tmp_path_factory.mktemp("studio")) as running:
        yield running


@pytest.fixture
def page(browser: Browser, studio: RunningStudio) -> Iterator[Driven]:
    """The studio's page, with nothing open."""
    context = browser.new_context(viewport={"width": SIZE[0], "height": SIZE[1]})
    context.set_default_timeout(20_000)
    driven = Driven(context.new_page(), studio)
    driven.load()
    driven.begin()
    yield driven
    context.close()
    assert not driven.errors, "errors in the page: " + "\n".join(driven.errors)
