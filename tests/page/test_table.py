"""The tab for tables behind the page: a radius from pasted cells, or what is wrong with them."""

from pathlib import Path

import pytest

from fitting.shell.page import table_task

CELLS = "order\tdiameter_mm\n5\t3.43\n10\t4.86\n15\t5.95\n20\t6.87\n25\t7.68\n30\t8.41\n"


def test_pasted_cells_give_a_radius_and_files_to_keep():
    answer = table_task.measure(Path(), print, CELLS, {"wavelength": "sodium"})
    assert answer["status"] == "ok"
    assert "radius = 1.00047 ± 0.00076 m" in answer["report"]
    assert set(answer["files"]) == {"rings.json", "rings.txt", "rings.png"}


@pytest.mark.parametrize(
    ("text", "texts", "words"),
    [
        ("", {}, "no table yet"),
        ("/etc/passwd", {"wavelength": "sodium"}, "."),
        (CELLS, {"wavelength": "lamp.csv"}, "names a file"),
        (CELLS, {"wavelength": "589"}, "has no unit"),
    ],
)
def test_what_is_no_table_is_refused(text, texts, words):
    with pytest.raises(ValueError, match=words) as caught:
        table_task.measure(Path(), print, text, texts)
    assert "root:" not in str(caught.value)
