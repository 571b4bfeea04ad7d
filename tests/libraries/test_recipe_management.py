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


def test_lists_of_recipes_are_refused() -> None:
    """The names of their inputs are those of a public project."""
    ran = Ran(
        "PROGRAM MAIN VAR recipes : RecipeManCommands; names, values, fields : DWORD;"
        " list : ARRAY [0..3] OF STRING; stored : BOOL := TRUE; END_VAR"
        " names := recipes.GetRecipeNames(RecipeDefinitionName := 'A', pStrings := ADR(list),"
        " iSize := 4, iStartIndex := 0); values := recipes.GetRecipeValues("
        "RecipeDefinitionName := 'A', RecipeName := 'B', pStrings := ADR(list), iSize := 4,"
        " iStartIndex := 0, iStringLength := 80); fields := recipes.GetRecipeVariableNames("
        "RecipeDefinitionName := 'A', RecipeName := 'B', pStrings := ADR(list), iSize := 4,"
        " iStartIndex := 0); stored := recipes.SetStoragePath('C'); END_PROGRAM"
    ).cycle()
    assert ran.plc.failure == ""
    assert (ran["names"], ran["values"], ran["fields"]) == (0x4006, 0x4006, 0x4006)
    assert ran["stored"] is False
