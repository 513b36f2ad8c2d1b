# The program, its manual and the scenes.
file(RELATIVE_PATH from_program ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
if(BUILD_SHARED_LIBS)
  set_target_properties(tress PROPERTIES INSTALL_RPATH "$ORIGIN/${from_program}")
endif()
install(TARGETS tress RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)

# Manual pages and completion, which the program makes of its own options.
set(manual ${PROJECT_BINARY_DIR}/manual)
file(MAKE_DIRECTORY ${manual})
add_custom_command(OUTPUT ${manual}/tress.1 ${manual}/tress-render.1 ${manual}/tress-diff.1 ${manual}/tress-info.1 ${manual}/tress-convert.1 ${manual}/tress-report.1 ${manual}/tress-farm.1 ${manual}/tress-cache.1
    ${manual}/tress.bash ${manual}/_tress DEPENDS tress
  COMMAND tress help --man > ${manual}/tress.1
  COMMAND tress help render --man > ${manual}/tress-render.1
  COMMAND tress help diff --man > ${manual}/tress-diff.1
  COMMAND tress help info --man > ${manual}/tress-info.1
  COMMAND tress help convert --man > ${manual}/tress-convert.1
  COMMAND tress help report --man > ${manual}/tress-report.1
  COMMAND tress help farm --man > ${manual}/tress-farm.1
  COMMAND tress help cache --man > ${manual}/tress-cache.1
  COMMAND tress help --completion bash > ${manual}/tress.bash
  COMMAND tress help --completion zsh > ${manual}/_tress)
add_custom_target(manual ALL DEPENDS ${manual}/tress.1)
install(DIRECTORY ${manual}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program FILES_MATCHING PATTERN "*.1")
install(FILES ${manual}/tress.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT program RENAME tress)
install(FILES ${manual}/_tress DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions COMPONENT program)
install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/tress COMPONENT program FILES_MATCHING PATTERN "*.json" PATTERN "*.obj" PATTERN "skin.png"
  PATTERN "tress_render" EXCLUDE)
file(GLOB_RECURSE pages CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} scenes/*.md)
list(FILTER pages EXCLUDE REGEX "/tress_render/")
foreach(page ${pages})
  install_document(${page} program)
endforeach()
