"""A browser for all tests of a run; each test opens pages of its own."""

import pytest

from tests.web import chromium


@pytest.fixture(scope="session")
def browser():
    if not chromium.find():
        pytest.skip(chromium.MISSING)
    with chromium.Chromium() as running:
        yield running


@pytest.fixture
def open_page(browser):
    """open_page(url, width=390): a tab that is closed at the end of the test."""
    opened = []

    def open_page(url, **how):
        opened.append(browser.open(url, **how))
        return opened[-1]

    yield open_page
    for page in opened:
        page.close()
