"""Pages of findings: one for each code, with its example."""

from achse.site.findings import INDEX, finding_pages
from achse.st.explanations.explanation import explanations
from achse.st.lexis.codes import Code


def test_each_code_has_a_page_and_a_row_in_the_list() -> None:
    pages = {file: text for _, file, text in finding_pages("made here")}
    assert set(pages) == {INDEX, *(f"{code}.md" for code in Code)}
    for code, each in explanations().items():
        assert pages[INDEX].count(f"| [{code}]({code}.md) | {each.title} |") == 1
        page = pages[f"{code}.md"]
        assert page.startswith(f"# {code}: {each.title}\n\nmade here\n")
        for text in (*each.wrong.values(), *each.right.values()):
            assert text.strip() in page
