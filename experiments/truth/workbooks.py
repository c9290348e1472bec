"""Made workbooks of spreadsheet programs: the least that the standards ask for."""

import io
import zipfile
from collections.abc import Mapping, Sequence
from xml.sax.saxutils import escape

_KINDS = "http://schemas.openxmlformats.org/package/2006"
_OFFICE = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
_MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
_TYPES = "application/vnd.openxmlformats-officedocument.spreadsheetml"


def xlsx(rows: Sequence[Sequence[object]]) -> bytes:
    """A workbook of one sheet by ECMA-376, with text in the cells themselves."""
    return xlsx_of_sheets({"rings": rows})


def xlsx_of_sheets(sheets: Mapping[str, Sequence[Sequence[object]]], merged: Sequence[str] = ()) -> bytes:
    """A workbook of sheets by name; None is an empty cell, and `merged` ranges such as A1:C1 are of the first sheet."""
    numbered = list(enumerate(sheets, 1))
    parts = "".join(f'<Override PartName="/xl/s{k}.xml" ContentType="{_TYPES}.worksheet+xml"/>' for k, _ in numbered)
    named = "".join(f'<sheet name="{escape(name)}" sheetId="{k}" r:id="b{k}"/>' for k, name in numbered)
    targets = "".join(f'<Relationship Id="b{k}" Type="{_OFFICE}/worksheet" Target="s{k}.xml"/>' for k, _ in numbered)
    contents = {f"xl/s{k}.xml": _sheet(sheets[name], merged if k == 1 else ()) for k, name in numbered}
    return _archive({
        "[Content_Types].xml": f'<Types xmlns="{_KINDS}/content-types"><Default Extension="rels" ContentType='
        '"application/vnd.openxmlformats-package.relationships+xml"/><Override PartName="/xl/workbook.xml" '
        f'ContentType="{_TYPES}.sheet.main+xml"/>{parts}</Types>',
        "_rels/.rels": f'<Relationships xmlns="{_KINDS}/relationships"><Relationship Id="a" '
        f'Type="{_OFFICE}/officeDocument" Target="xl/workbook.xml"/></Relationships>',
        "xl/workbook.xml": f'<workbook xmlns="{_MAIN}" xmlns:r="{_OFFICE}"><sheets>{named}</sheets></workbook>',
        "xl/_rels/workbook.xml.rels": f'<Relationships xmlns="{_KINDS}/relationships">{targets}</Relationships>',
        **contents,
    })  # fmt: skip


def _sheet(rows: Sequence[Sequence[object]], merged: Sequence[str]) -> str:
    lines = "".join(
        f'<row r="{k}">{"".join(_cell(value, k, j) for j, value in enumerate(row))}</row>'
        for k, row in enumerate(rows, 1)
    )
    ranges = "".join(f'<mergeCell ref="{cells}"/>' for cells in merged)
    merges = f"<mergeCells>{ranges}</mergeCells>" if merged else ""
    return f'<worksheet xmlns="{_MAIN}"><sheetData>{lines}</sheetData>{merges}</worksheet>'


def _cell(value: object, row: int, column: int) -> str:
    place = f'r="{chr(65 + column)}{row}"'
    if value is None:
        return f"<c {place}/>"
    if isinstance(value, str):
        return f'<c {place} t="inlineStr"><is><t>{escape(value)}</t></is></c>'
    return f"<c {place}><v>{value}</v></c>"


def ods(rows: Sequence[Sequence[object]]) -> bytes:
    """A workbook of one sheet by OASIS OpenDocument 1.2."""
    space = "urn:oasis:names:tc:opendocument:xmlns"
    kind = "application/vnd.oasis.opendocument.spreadsheet"

    def cell(value: object) -> str:
        if isinstance(value, str):
            return f'<table:table-cell office:value-type="string"><text:p>{escape(value)}</text:p></table:table-cell>'
        shown = f"<text:p>{value}</text:p>"
        return f'<table:table-cell office:value-type="float" office:value="{value}">{shown}</table:table-cell>'

    lines = [f"<table:table-row>{''.join(map(cell, row))}</table:table-row>" for row in rows]
    return _archive({
        "mimetype": kind,
        "META-INF/manifest.xml": f'<manifest:manifest xmlns:manifest="{space}:manifest:1.0"><manifest:file-entry '
        f'manifest:full-path="/" manifest:media-type="{kind}"/></manifest:manifest>',
        "content.xml": f'<office:document-content xmlns:office="{space}:office:1.0" xmlns:table="{space}:table:1.0" '
        f'xmlns:text="{space}:text:1.0"><office:body><office:spreadsheet><table:table table:name="rings">'
        f"{''.join(lines)}</table:table></office:spreadsheet></office:body></office:document-content>",
    })  # fmt: skip


def _archive(files: dict[str, str]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return stream.getvalue()
