"""The page, served once for all its tests."""

import pytest
from serving_page import served


@pytest.fixture(scope="session")
def page(tmp_path_factory):
    pytest.importorskip("nicegui", reason="the extra app is not installed")
    with served(tmp_path_factory.mktemp("page")) as running:
        yield running
