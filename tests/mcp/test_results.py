"""Schemas of results are short and whole."""

from achse.mcp import results
from tests.public_names import public_names


def test_each_result_has_a_schema_without_titles() -> None:
    for name in public_names(results):
        model = getattr(results, name)
        schema = model.model_json_schema()
        assert schema["description"]
        assert "title" not in schema
        assert all("title" not in each for each in schema["properties"].values())
