"""Workbooks as spreadsheets write them."""

import io
import zipfile


def workbook(sheets: dict[str, list[list]]) -> bytes:
    """An .xlsx with inline strings: the least that the format wants."""
    kind = "http://schemas.openxmlformats.org"
    names = list(sheets)

    def cell(value: object) -> str:
        return (
            f'<c t="inlineStr"><is><t>{value}</t></is></c>'
            if isinstance(value, str)
            else f"<c><v>{float(value)!r}</v></c>"
        )

    with zipfile.ZipFile(out := io.BytesIO(), "w") as z:
        z.writestr(
            "[Content_Types].xml", f'<Types xmlns="{kind}/package/2006/content-types"/>'
        )
        z.writestr(
            "_rels/.rels",
            f'<Relationships xmlns="{kind}/package/2006/relationships"><Relationship'
            f' Id="r0" Type="{kind}/officeDocument/2006/relationships/officeDocument"'
            ' Target="xl/workbook.xml"/></Relationships>',
        )
        listed = "".join(
            f'<sheet name="{n}" sheetId="{k}" r:id="r{k}"/>'
            for k, n in enumerate(names, 1)
        )
        z.writestr(
            "xl/workbook.xml",
            f'<workbook xmlns="{kind}/spreadsheetml/2006/main" '
            f'xmlns:r="{kind}/officeDocument/2006/relationships"><sheets>{listed}</sheets></workbook>',
        )
        related = "".join(
            f'<Relationship Id="r{k}"'
            f' Type="{kind}/officeDocument/2006/relationships/worksheet"'
            f' Target="worksheets/sheet{k}.xml"/>'
            for k in range(1, len(names) + 1)
        )
        z.writestr(
            "xl/_rels/workbook.xml.rels",
            "<Relationships"
            f' xmlns="{kind}/package/2006/relationships">{related}</Relationships>',
        )
        for k, name in enumerate(names, 1):
            rows = "".join(
                f"<row>{''.join(map(cell, row))}</row>" for row in sheets[name]
            )
            z.writestr(
                f"xl/worksheets/sheet{k}.xml",
                "<worksheet"
                f' xmlns="{kind}/spreadsheetml/2006/main">'
                f"<sheetData>{rows}</sheetData></worksheet>",
            )
    return out.getvalue()


def bomb(megabytes: int) -> bytes:
    """An .xlsx of some kB whose one sheet unpacks to so many megabytes."""
    made = io.BytesIO(workbook({"a": [[1.0]]}))
    with (
        zipfile.ZipFile(made, "a", zipfile.ZIP_DEFLATED) as z,
        z.open("xl/worksheets/sheet2.xml", "w", force_zip64=True) as sheet,
    ):
        block = b"<c><v>1</v></c>" * 70_000
        for _ in range(megabytes):
            sheet.write(block)
    return made.getvalue()
