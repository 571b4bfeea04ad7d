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


def test_results_of_commands_stand_alone() -> None:
    ran = Ran(
        "PROGRAM MAIN VAR recipes : RecipeManCommands; last : DWORD; none, ok : BOOL; END_VAR"
        " recipes.DeleteRecipe('A', 'B'); last := recipes.GetLastError();"
        " none := last = ERR_NO_RECIPE_MANAGER_SET; ok := last = ERR_OK; END_PROGRAM"
    ).cycle()
    assert (ran["last"], ran["none"], ran["ok"]) == (0x4006, True, False)
