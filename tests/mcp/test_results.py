"""Schemas of results are short and whole."""

from achse.mcp import results


def test_each_result_has_a_schema_without_titles() -> None:
    for name in results.__all__:
        model = getattr(results, name)
        schema = model.model_json_schema()
        assert schema["description"]
        assert "title" not in schema
        assert all("title" not in each for each in schema["properties"].values())
