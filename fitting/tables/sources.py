"""From a file, or from pasted text, to rows of cells: encodings, separators, workbooks of spreadsheet programs."""

import codecs
import csv
import datetime as dt
import io
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from fitting.tables.cells import is_number, unit_in
from fitting.tables.markup import plain_lines, without_emphasis
from fitting.tables.vocabulary import count_of_foreign_words

# Excel says its delimiter in a line of its own.
_STATED = re.compile(r'\s*"?sep=([,;\t|]?).?"?\s*', re.IGNORECASE)
_COMMENTS = ("#", "%", "//")
_COMMENT_BEHIND = re.compile(r"^(\s*[\d\"'].*?)\s#\s.*")
# Workbooks, new (a ZIP archive) and old (a compound file).
_ARCHIVE, _COMPOUND = b"PK\x03\x04", b"\xd0\xcf\x11\xe0"
# Characters that no table has.
_NO_TEXT = re.compile(r"[\x00-\x08\x0e-\x1b\x7f\ufffe\uffff]")
_BLANKS = re.compile(r"[ \t\r\n]+")
_ENCODINGS = ("cp1252", "cp1251", "gb18030", "shift_jis", "euc_kr", "cp1250", "cp1253")
SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t", "bar": "|", "blank": " "}
_NAMES = {separator: f"{name}s" for name, separator in SEPARATORS.items()} | {"&": "&", ":": "colons"}
# Tried in this order; of those that read as well, the first.
_TRIED = ("\t", ";", "|", "&", ",", " ", ":")
# Lines that tell the separator, and more line breaks than a quoted cell has.
_LOOKED_AT, _BREAKS = 200, 3
# Bytes by which a text differs from a picture.
_HEAD = 4096


@dataclass(frozen=True)
class Grid:
    """Rows of cells as they are written, the line of the file that each stands on, and comments beside them.

    `form`: how they were read, such as "semicolons, cp1251"; `separator`: between cells, "" of a workbook.
    """

    rows: list[list[str]]
    lines: list[int]
    separator: str
    form: str
    comments: list[str]


def is_table(path: Path) -> bool:
    """Whether a file is a text or a workbook, by its first bytes; a picture, or an archive of arrays, is none."""
    with path.open("rb") as file:
        head = file.read(_HEAD)
    if head.startswith((_ARCHIVE, _COMPOUND)):
        return path.suffix.lower() != ".npz"
    # The last character of so many bytes may be cut.
    return any(_is_text(head[: len(head) - cut]) for cut in range(4 if len(head) == _HEAD else 1))


def _is_text(content: bytes) -> bool:
    try:
        text_of(content, "")
    except ValueError:
        return False
    return True


def grids_of(table: str | Path, separator: str | None = None, encoding: str | None = None) -> list[Grid]:
    """The cells of a file, or of a text with line breaks that was pasted; of a workbook a grid for each filled sheet.

    Raises FileNotFoundError, and ValueError for what is no table, and for an encoding or separator that there is not.
    """
    if separator is not None and separator not in (*SEPARATORS, *SEPARATORS.values()):
        raise ValueError(f"separator is {separator!r}; allowed: {', '.join(SEPARATORS)}")
    separator = SEPARATORS.get(separator or "", separator)
    if isinstance(table, str) and "\n" in table:
        return [_of_text(table, "the text", separator, "")]
    path = Path(table)
    if not path.is_file():
        raise FileNotFoundError(f"{path} is no file; give the path of a table of ring readings (CSV with a header)")
    content = path.read_bytes()
    if content.startswith((_ARCHIVE, _COMPOUND)):
        return _of_workbook(path, content)
    text, read_as = text_of(content, str(path), encoding)
    return [_of_text(text, str(path), separator, read_as)]


def text_of(content: bytes, name: str, encoding: str | None = None) -> tuple[str, str]:
    """The text of bytes, and its encoding where that is not UTF-8.

    UTF-8, UTF-16 with a byte-order mark or without, else the one of Western, Cyrillic, Chinese, Japanese, Korean,
    Central European and Greek Windows in which most words of a table's header are found. Raises ValueError for what is
    no text.
    """
    if encoding is not None:
        try:
            text = content.decode(codecs.lookup(encoding).name)
        except LookupError:
            raise ValueError(f"encoding is {encoding!r}; give one such as utf-8, utf-16, cp1252, cp1251, gbk") from None
        except UnicodeDecodeError as error:
            raise ValueError(f"{name} is not in {encoding} ({error.reason}); leave the encoding out") from None
        return text.removeprefix("\ufeff"), encoding
    for candidate in _unicode_encodings(content):
        with suppress(UnicodeDecodeError):
            text = content.decode(candidate)
            if not _NO_TEXT.search(text):
                return text, "" if candidate == "utf-8-sig" else candidate
    best = None
    for candidate in () if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)) else _ENCODINGS:
        with suppress(UnicodeDecodeError):
            text = content.decode(candidate)
            words = count_of_foreign_words(text[:5000])
            if not _NO_TEXT.search(text) and (best is None or words > best[0]):
                best = (words, text, candidate)
    if best is None:
        raise ValueError(f"{name} is no text; give a table of readings (CSV with a header)")
    return best[1], best[2]


def _unicode_encodings(content: bytes) -> Sequence[str]:
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return ("utf-16",)
    # Half of the bytes of Latin text in UTF-16 are zero.
    for offset, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
        if len(content) > 8 and content[offset::2].count(0) > 0.3 * len(content) / 2:
            return (encoding,)
    return ("utf-8-sig",)


def _of_text(text: str, name: str, separator: str | None, encoding: str) -> Grid:
    lines = [_COMMENT_BEHIND.sub(r"\1", line) for line in plain_lines(text).splitlines(keepends=True)]
    stated = [_STATED.fullmatch(line.rstrip("\r\n")) for line in lines]
    comments = [line.strip().lstrip("#%/ ") for line in lines if _is_comment(line)]
    # What is no row leaves a blank line: the lines' numbers stay.
    rows = ["\n" if _is_comment(line) or match else line for line, match in zip(lines, stated, strict=True)]
    if not any(line.strip() for line in rows):
        raise ValueError(f"{name} holds no readings; give a header and one row a ring")
    by_file = next((match[1] for match in stated if match and match[1]), "")
    between = separator or by_file or _separator_of(rows)
    try:
        cells, numbers = _split(rows, between)
    except csv.Error as error:
        raise ValueError(f"{name} is no CSV file ({error}); give a header and one row a ring") from None
    form = ", ".join(filter(None, [_NAMES[between], encoding]))
    return Grid(_with_wide_header(cells), numbers, between, form, comments)


def _with_wide_header(rows: list[list[str]]) -> list[list[str]]:
    """Rows; one of one cell above the numbers is cut at another separator where that makes as many as those have."""
    first = next((k for k, row in enumerate(rows) if any(map(is_number, row))), 0)
    width = len(rows[first]) if rows else 0
    for k in range(first if width > 1 else 0):
        cuts = [rows[k][0].split(separator) for separator in _TRIED if len(rows[k]) == 1]
        fitting_cut = next((cut for cut in cuts if len(cut) == width), rows[k])
        rows[k] = [cell.strip() for cell in fitting_cut]
    return rows


def _is_comment(line: str) -> bool:
    """Whether a line is a comment; a header may begin with a sign for numbers: "#;D (mm)"."""
    text = line.strip()
    return text.startswith(_COMMENTS) and not re.match(r"#\s*[,;\t|]", text)


def _separator_of(rows: Sequence[str]) -> str:
    """The separator that cuts the lines with digits into most numbers and least else."""
    with_digits = [row for row in rows if any(letter.isdigit() for letter in row)][:_LOOKED_AT]
    scores = {}
    for separator in _TRIED:
        if separator != " " and not any(separator in row for row in with_digits):
            continue
        with suppress(csv.Error):
            cells = _split(with_digits, separator)[0]
            numbers = [sum(map(is_number, row)) for row in cells]
            texts = [sum(bool(cell) for cell in row) for row in cells]
            scores[separator] = sum(min(2 * n - t, 6) for n, t in zip(numbers, texts, strict=True))
    return max(scores, key=lambda separator: scores[separator]) if scores else ","


def _split(rows: Sequence[str], separator: str) -> tuple[list[list[str]], list[int]]:
    """Cells of rows, and the number of the line that each row ends on; blank rows are left out."""
    if separator == " ":
        split = [(_at_blanks(row), n) for n, row in enumerate(rows, 1)]
    else:
        split = list(_at(rows, separator, csv.QUOTE_MINIMAL))
        # A quote that is no quote, as of inches, swallows what follows.
        if any(cell.count("\n") > _BREAKS for row, _ in split for cell in row):
            split = list(_at(rows, separator, csv.QUOTE_NONE))
    # Narrow blanks stay: they stand between thousands.
    cells = [([_BLANKS.sub(" ", cell).strip() for cell in row], n) for row, n in split]
    if separator in "|&":
        cells = [(_without_frame(row), n) for row, n in cells]
    cells = [(row, n) for row, n in cells if any(row) and not _is_rule(row)]
    return [row for row, _ in cells], [n for _, n in cells]


def _at(rows: Sequence[str], separator: str, quoting: int) -> Iterator[tuple[list[str], int]]:
    reader = csv.reader(rows, delimiter=separator, quoting=quoting, skipinitialspace=True)  # pyright: ignore[reportArgumentType]
    for row in reader:
        yield row, reader.line_num


def _at_blanks(row: str) -> list[str]:
    """Cells between blanks, those of several words where two blanks or more stand between all."""
    wide = [part for part in re.split(r"\s{2,}|\t", row.strip()) if part]
    if len(wide) > 1 and not any(" " in part and all(map(is_number, part.split())) for part in wide):
        return wide
    cells: list[str] = []
    for part in row.split():
        is_more = cells and (
            cells[-1].count("(") > cells[-1].count(")")
            or cells[-1].count("[") > cells[-1].count("]")
            or part[0] in "([±/"
            or cells[-1][-1] in "±/"
            or (is_number(cells[-1]) and unit_in(part) is not None)
        )
        cells = [*cells[:-1], f"{cells[-1]} {part}"] if is_more else [*cells, part]
    return cells


def _without_frame(row: list[str]) -> list[str]:
    """Cells without what frames them in Markdown and LaTeX."""
    row = [without_emphasis(cell.removesuffix("\\\\").strip()) for cell in row]
    return row[1 if row and not row[0] else 0 : len(row) - 1 if len(row) > 1 and not row[-1] else len(row)]


def _is_rule(row: list[str]) -> bool:
    """Whether a row is a line drawn with signs."""
    text = "".join(row)
    return len(text) > 2 and not set(text) - set("-=_:+|* ")


def _of_workbook(path: Path, content: bytes) -> list[Grid]:
    """The sheets of a workbook that have rows. Raises ValueError for an archive of something else."""
    try:
        from python_calamine import CalamineError, CalamineWorkbook  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise ValueError(
            f"{path} is a workbook of a spreadsheet program, which needs python-calamine; install it: pip install "
            "'newtonjax[sheets]', or save its sheet as CSV and give that"
        ) from None
    try:
        book = CalamineWorkbook.from_filelike(io.BytesIO(content))
        sheets = [(name, book.get_sheet_by_name(name).to_python(skip_empty_area=False)) for name in book.sheet_names]
    except (CalamineError, ValueError, OSError) as error:
        raise ValueError(f"{path} is no workbook that can be read ({error}); save its sheet as CSV") from None
    filled = [(name, rows) for name, rows in sheets if sum(any(map(_written, row)) for row in rows) > 1]
    if not filled:
        raise ValueError(f"{path} holds no readings; give a sheet with a header and one row a ring")
    return [_of_sheet(name, rows, len(filled)) for name, rows in filled]


def _of_sheet(name: str, rows: list[list], count: int) -> Grid:
    cells = [([_written(cell) for cell in row], n) for n, row in enumerate(rows, 1)]
    cells = [(row, n) for row, n in cells if any(row)]
    further = f" of {count}" if count > 1 else ""
    return Grid([row for row, _ in cells], [n for _, n in cells], "", f"sheet {name!r}{further}", [])


def _written(cell: object) -> str:
    """A workbook's cell as text."""
    if isinstance(cell, float):
        return f"{cell:.12g}"
    if isinstance(cell, dt.date | dt.time):
        return cell.isoformat()
    return " ".join(str(cell).split())
