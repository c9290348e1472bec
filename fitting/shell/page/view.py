"""The page: its head, and its three tabs."""

from nicegui import ui  # pyright: ignore[reportMissingImports]  # an extra

from fitting.shell.page import parts
from fitting.shell.page.bench_tab import BenchTab
from fitting.shell.page.photograph_tab import PhotographTab
from fitting.shell.page.sessions import Sessions
from fitting.shell.page.table_tab import TableTab
from fitting.shell.page.worker import Worker

# The default blue has too little contrast.
_BLUE = "#1a4f9c"


def show(sessions: Sessions, photographs: Worker, bench: Worker, token: str) -> None:
    """Build the page for one tab of a browser, which is forgotten when it closes; by its token, the same again."""
    session = sessions.open(token)
    ui.context.client.on_delete(lambda: sessions.close(session.token))
    ui.colors(primary=_BLUE)
    ui.add_css(parts.resource("page.css"))
    ui.add_body_html(f"<script>{parts.resource('page.js')}</script>")
    with ui.element("div").classes("nj-page"):
        parts.heading("newtonjax: Newton's rings", 1)
        with ui.tabs().props("align=left no-caps") as tabs:
            photograph, bench_head, table = map(ui.tab, ("Photograph", "Virtual bench", "Table of rings"))
        virtual = BenchTab(session, bench)
        tabs.on_value_change(lambda event: virtual.begin() if event.value == "Virtual bench" else None)
        with ui.tab_panels(tabs, value=photograph).props("keep-alive"):
            with ui.tab_panel(photograph):
                PhotographTab(session, photographs).build()
            with ui.tab_panel(bench_head):
                virtual.build()
            with ui.tab_panel(table):
                TableTab(session, photographs).build()
