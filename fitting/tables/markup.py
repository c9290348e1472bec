"""Tables of pages and programs as text with a separator: HTML, LaTeX, wikis, JSON, frames drawn with lines."""

import json
import re
from collections.abc import Callable, Mapping
from html.parser import HTMLParser
from typing import Any

# Soft hyphens, blanks of no width, marks of the writing's direction.
_UNSEEN = re.compile("[\u00ad\u200b\u2060\u200e\u200f\ufeff]")
_FRAME = re.compile("[║│┃┆┊]")
_FRAME_RULE = re.compile("[\\s─-╿|+]*[─-╿][\\s─-╿|+]*")
_IS_LATEX = re.compile(r"\\(?:begin|end|hline|toprule|midrule|num|si|SI|qty|unit|pm|mathrm|text\w*|times|cdot)\b")
_LATEX_RULE = re.compile(r"\s*\\(?:begin|end|centering|caption|label|cline|cmidrule|usepackage|documentclass)\b.*")
_RULES = re.compile(r"\\(?:hline|toprule|midrule|bottomrule)\b")
_PREFIXED = re.compile(r"\\(milli|centi|micro)\s*\\met(?:re|er)\b")
_PREFIXES = {"milli": "mm", "centi": "cm", "micro": "um"}
_QUANTITY = re.compile(r"\\(?:SI|qty)\s*(?:\[[^\]]*\])?\{([^{}]*)\}\s*\{([^{}]*)\}")
_WRAPPED = re.compile(r"\\(?:num|si|unit|math\w+|text\w*|emph)\s*\{([^{}]*)\}")
_SPANNED = re.compile(r"\\multicolumn\s*\{(\d+)\}\s*\{[^{}]*\}\s*\{([^{}]*)\}")
_WORDS = {r"\metre": "m", r"\meter": "m", r"\mm": "mm", r"\cm": "cm", r"\um": "um", r"\squared": "^2", r"\pm": "±",
          r"\times": "×", r"\cdot": "·", r"\,": " ", r"\;": " ", r"\%": "%", "$": "", "~": " "}  # fmt: skip
_LATEX_COMMENT = re.compile(r"(?<!\\)%.*")
_EMPHASIS = re.compile(r"(\*\*|\*|__|_|`)(?=\S)(.+)(?<=\S)\1")


def plain_lines(text: str) -> str:
    """A text with its tables as cells between separators; what is no markup stays as it is.

    Of LaTeX, frames and wikis each line stays on its line.
    """
    text = _UNSEEN.sub("", text)
    start = text.lstrip()[:2000].lower()
    if "<table" in start or "<html" in start or "<tr" in start:
        return _of_html(text) or text
    if start.startswith(("{", "[")):
        of_json = _of_json(text)
        if of_json:
            return of_json
    if start.startswith("{|") or "\n{|" in text:
        return _by_line(text, _of_wiki)
    if _IS_LATEX.search(text):
        return _by_line(text, _of_latex)
    return _by_line(text, _without_lines) if re.search("[─-╿]", text) else text


def without_emphasis(cell: str) -> str:
    """A cell of Markdown without what makes it bold, slanted or code."""
    match = _EMPHASIS.fullmatch(cell)
    return match[2] if match else cell


def _by_line(text: str, convert: Callable[[str], str]) -> str:
    return "\n".join(convert(line) for line in text.splitlines()) + "\n"


def _without_lines(line: str) -> str:
    return "" if _FRAME_RULE.fullmatch(line) else _FRAME.sub("|", line)


def _of_wiki(line: str) -> str:
    text = line.strip()
    if text.startswith(("{|", "|}", "|-", "|+")):
        return ""
    return text.lstrip("|!").replace("!!", "||").replace("||", "\t")


def _of_latex(line: str) -> str:
    line = _LATEX_COMMENT.sub("", line)
    if _LATEX_RULE.fullmatch(line):
        return ""
    line = _PREFIXED.sub(lambda match: _PREFIXES[match[1]], _RULES.sub("", line))
    line = _SPANNED.sub(lambda match: match[2] + " &" * (int(match[1]) - 1), _QUANTITY.sub(r"\1 \2", line))
    for word, sign in _WORDS.items():
        line = line.replace(word, sign) if not word[-1].isalpha() else re.sub(re.escape(word) + r"\b", sign, line)
    for _ in range(2):
        line = _WRAPPED.sub(r"\1", line)
    return line.strip()


class _Cells(HTMLParser):
    """The cells of a page's tables, row by row."""

    def __init__(self) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self._is_cell = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "tr":
            self.rows.append([])
        elif tag in ("td", "th") and self.rows:
            span = dict(attrs).get("colspan") or "1"
            # What a cell spans to its right is empty.
            count = min(int(span), 100) if span.isdecimal() else 1
            self.rows[-1] += ["", *[""] * (count - 1)]
            self._place, self._is_cell = len(self.rows[-1]) - count, True
        elif tag == "br" and self._is_cell:
            self.handle_data(" ")

    def handle_endtag(self, tag: str) -> None:
        self._is_cell = self._is_cell and tag not in ("td", "th", "tr", "table")

    def handle_data(self, data: str) -> None:
        if self._is_cell and self.rows[-1]:
            self.rows[-1][self._place] += " ".join(data.split()) if data.strip() else " "


def _of_html(text: str) -> str:
    parser = _Cells()
    parser.feed(text)
    parser.close()
    return "".join("\t".join(cell.strip() for cell in row) + "\n" for row in parser.rows if any(row))


def _of_json(text: str) -> str:
    """Columns by name, or rows by the names of their cells; "" for JSON of another kind."""
    try:
        table = json.loads(text)
    except (ValueError, RecursionError):
        return ""
    if isinstance(table, Mapping):
        columns = {name: cells for name, cells in table.items() if isinstance(cells, list)}
        if not columns or len({len(cells) for cells in columns.values()}) != 1:
            return ""
        rows = [list(columns), *zip(*columns.values(), strict=True)]
    elif isinstance(table, list) and table and all(isinstance(row, Mapping) for row in table):
        names = list(dict.fromkeys(name for row in table for name in row))
        rows = [names, *([row.get(name, "") for name in names] for row in table)]
    elif isinstance(table, list) and table and all(isinstance(row, list) for row in table):
        rows = table
    else:
        return ""
    return "".join("\t".join(map(_of_value, row)) + "\n" for row in rows)


def _of_value(value: Any) -> str:
    return "" if value is None or isinstance(value, list | dict) else " ".join(str(value).split())
