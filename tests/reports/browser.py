"""A browser without a window for tests of pages; what it loads and what goes wrong in it is written down."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Final

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page, Playwright

#: Names under which browsers of this kind are installed.
NAMES: Final = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
#: WebGL without a graphics card.
DRAWING: Final = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


@dataclass
class Visit:
    """A page that is open, what it asked for and what it complained of."""

    page: "Page"
    requests: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)


@contextmanager
def playing() -> Iterator["Playwright"]:
    """Start what drives browsers; at most one at a time. A test is skipped where it is not installed."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with sync_api.sync_playwright() as playwright:
        yield playwright


def start(playwright: "Playwright", *flags: str) -> "Browser":
    """Start a browser; a test is skipped where there is none."""
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip(f"no browser is installed: none of {', '.join(NAMES)}")
    return playwright.chromium.launch(executable_path=path, args=["--no-sandbox", *flags])


@contextmanager
def visit(browser: "Browser", path: Path, *, width: int = 1280, scripts: bool = True) -> Iterator[Visit]:
    """Open a file."""
    context = browser.new_context(viewport={"width": width, "height": 900}, java_script_enabled=scripts, offline=True)
    context.set_default_timeout(10_000)
    page = context.new_page()
    made = Visit(page)
    page.on("console", lambda message: made.complaints.append(f"{message.type}: {message.text}"))
    page.on("pageerror", lambda error: made.complaints.append(str(error)))
    page.on("request", lambda request: made.requests.append(request.url))
    try:
        page.goto(path.as_uri())
        yield made
    finally:
        context.close()
