"""Formatting: edits of the beginnings and ends of lines in a document, and nothing in XML."""

from collections.abc import Iterator

from lsprotocol import types

from achse.lsp.documents import Document
from achse.lsp.editor import Editor
from achse.st.files.forms import Content, has_content
from achse.st.formatting.options import FormatOptions, FormatOptionsError, format_options
from achse.st.formatting.sources import formatted_source

_NO_LINES = 1 << 31


def format_document(
    editor: Editor, params: types.DocumentFormattingParams
) -> list[types.TextEdit] | None:
    """Return the edits that give a document its layout."""
    return _edits(editor, params.text_document.uri, params.options, 0, _NO_LINES)


def format_range(
    editor: Editor, params: types.DocumentRangeFormattingParams
) -> list[types.TextEdit] | None:
    """Return the edits of lines in a range."""
    place = params.range
    last = place.end.line - (place.end.character == 0 and place.end.line > place.start.line)
    uri, options = params.text_document.uri, params.options
    return _edits(editor, uri, options, place.start.line, last)


def _edits(
    editor: Editor, uri: str, client: types.FormattingOptions, first: int, last: int
) -> list[types.TextEdit] | None:
    file = editor.file_of(uri)
    document = editor.document_of(file)
    if document is None:
        return None
    try:
        options = format_options(file)
    except FormatOptionsError:  # which is shown already
        options = FormatOptions()
    is_xml = not has_content(file, Content.TEXT)
    fallback = client.tab_size if client.insert_spaces else 0
    formatted = Document(
        formatted_source(document.text, options, is_xml=is_xml, fallback=fallback),
        document.encoding,
    )
    if formatted.line_count != document.line_count:
        return None
    lines = range(first, min(last, document.line_count - 1) + 1)
    return [edit for number in lines for edit in _line_edits(document, formatted, number)]


def _line_edits(document: Document, formatted: Document, number: int) -> Iterator[types.TextEdit]:
    """Return the edits of one line, each as small as it can be."""
    before, after = document.line(number), formatted.line(number)
    if before == after:
        return
    end = len(before)
    if before.strip() == after.strip():  # its ends alone
        start = len(before) - len(before.lstrip())
        blanks = after[: len(after) - len(after.lstrip())]
        tail = len(before.rstrip())
        if tail == 0:
            yield types.TextEdit(_range(document, number, 0, end), after)
            return
        if before[:start] != blanks:
            yield types.TextEdit(_range(document, number, 0, start), blanks)
        if before[tail:] != after[len(after.rstrip()) :]:
            yield types.TextEdit(_range(document, number, tail, end), after[len(after.rstrip()) :])
        return
    yield types.TextEdit(_range(document, number, 0, end), after)


def _range(document: Document, line: int, start: int, end: int) -> types.Range:
    return types.Range(
        document.position_of(line + 1, start + 1), document.position_of(line + 1, end + 1)
    )
