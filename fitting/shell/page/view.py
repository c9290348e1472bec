"""The page: its head, and its three tabs."""

from nicegui import ui  # pyright: ignore[reportMissingImports]  # an extra

from fitting.shell.page import parts
from fitting.shell.page.photograph_tab import PhotographTab
from fitting.shell.page.sessions import Sessions
from fitting.shell.page.worker import Worker

# The default blue has too little contrast.
_BLUE = "#1a4f9c"


def show(sessions: Sessions, photographs: Worker) -> None:
    """Build the page for one tab of a browser, which is forgotten when it closes."""
    session = sessions.open()
    ui.context.client.on_delete(lambda: sessions.close(session.token))
    ui.colors(primary=_BLUE)
    ui.add_css(parts.resource("page.css"))
    ui.add_body_html(f"<script>{parts.resource('page.js')}</script>")
    with ui.element("div").classes("nj-page"):
        parts.heading("newtonjax: Newton's rings", 1)
        with ui.tabs().props("align=left no-caps") as tabs:
            photograph = ui.tab("Photograph")
        with ui.tab_panels(tabs, value=photograph).props("keep-alive"), ui.tab_panel(photograph):
            PhotographTab(session, photographs).build()
