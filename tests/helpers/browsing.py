"""Pages in a real browser, for tests: Debian's Chromium, or another one that is there."""

import contextlib
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

CHROMIUM = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), ""
)

FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


@contextlib.contextmanager
def opened_page(browser: "Browser", address: str, width: int = 1300, *, offline: bool = False) -> Iterator["Page"]:
    """A page, without a word of trouble in its console until the end; `offline`: and without a network."""
    context = browser.new_context(viewport={"width": width, "height": 1000}, offline=offline, color_scheme="light")
    page = context.new_page()
    troubles: list[str] = []
    page.on("console", lambda line: troubles.append(line.text) if line.type == "error" else None)
    page.on("pageerror", lambda error: troubles.append(str(error)))
    page.on("requestfailed", lambda request: troubles.append(request.url))
    page.goto(address)
    try:
        yield page
        assert not troubles
    finally:
        context.close()


def from_disk(browser: "Browser", path: Path, width: int = 1300) -> contextlib.AbstractContextManager["Page"]:
    """A page as somebody opens it who was sent the file: from disk, the network off."""
    return opened_page(browser, path.resolve().as_uri(), width, offline=True)
