"""Recipe Management: commands answer that recipe management in the PLC is off."""

from tests.plc.code.conftest import Ran


def test_recipe_commands_answer_that_no_manager_is_set() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR recipes : RecipeManCommands; loaded, created, last, cleared : DWORD;"
        " count : INT; refused : BOOL; END_VAR"
        " loaded := recipes.LoadAndWriteRecipe(RecipeDefinitionName := 'A', RecipeName := 'B');"
        " created := recipes.CreateRecipe('A', 'B'); count := recipes.GetRecipeCount('A');"
        " last := recipes.GetLastError(); recipes.ResetLastError();"
        " cleared := recipes.GetLastError();"
        " refused := last = ReturnValues.ERR_NO_RECIPE_MANAGER_SET; END_PROGRAM"
    ).cycle()
    main = ran.plc.instance("MAIN")
    assert (main["loaded"], main["created"], main["last"]) == (0x4006, 0x4006, 0x4006)
    assert (main["count"], main["cleared"], main["refused"]) == (0, 0, True)
