# The longest tests start first, so that none is left over for one core at the end. CTest sorts by COST.
foreach(test
    evidence.samples_follow_the_density_over_all_parameters_and_states
    Browser.LivePageAndReport
    Documents.CommandsRunAsTheyStand
    Packages.AreWholeAndWorkUnpacked
    Embedding.ExamplesBuildAndRunAgainstAnInstalledPrefix
    Scenes.RenderFiniteAndNotEmpty
    Python.render
    Rough.IsUnbiasedWhereNoRowHasConverged
    Chiang2016.AWhiteLockIsWhatASecondProgramSays
    Flicker.ALearnedTurntableDiffersFromATracedOneByNoiseOnly
    Noise.is_what_pictures_of_many_seeds_show_adaptive_or_not
    RoughModel.HasTheEnergiesOfItsPathsUnderAbsorption)
  set_tests_properties(${test} PROPERTIES COST 100)
endforeach()
