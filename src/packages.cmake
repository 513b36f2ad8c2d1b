# Debian packages, by CPack: one for each component of `cmake --install`. `cpack -G DEB` in the build folder makes
#   tress           the program, its manual and the scenes      (program)
#   libtress0.N     shared libraries, with BUILD_SHARED_LIBS     (library)
#   libtress-dev    what find_package(tress) finds               (development)
#   python3-tress   import tress, with TRESS_BUILD_PYTHON        (python)
#   blender-tress   the render engine of Blender                 (blender)
#   tress-lab       the rivals and what measures them            (laboratory)
# Which libraries they need is read from the files by dpkg-shlibdeps.
# Where Debian's Blender looks: 3.4 (Debian 12) in `addons`, 4.3 (Debian 13) in `addons_core` alone.
set(addons ${CMAKE_INSTALL_DATADIR}/blender/scripts)
install(DIRECTORY scenes/blender/tress_render DESTINATION ${addons}/addons COMPONENT blender FILES_MATCHING PATTERN "*.py"
  PATTERN "__pycache__" EXCLUDE)
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
file(CREATE_LINK ../addons/tress_render ${PROJECT_BINARY_DIR}/packages/tress_render SYMBOLIC)
install(FILES ${PROJECT_BINARY_DIR}/packages/tress_render DESTINATION ${addons}/addons_core COMPONENT blender)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tress)
set(CPACK_PACKAGE_CONTACT "The authors of tress <tress@example.org>")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR})
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/src/package_files.cmake)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_COMPONENTS_ALL)

# The changelog that Debian asks for, the same bytes every time.
set(changelog ${PROJECT_BINARY_DIR}/packages/changelog)
file(WRITE ${changelog} "tress (${PROJECT_VERSION}) unstable; urgency=medium\n\n  * Version ${PROJECT_VERSION}.\n\n -- ${CPACK_PACKAGE_CONTACT}  Thu, 01 Jan 2026 00:00:00 +0000\n")
execute_process(COMMAND gzip -9nf ${changelog} COMMAND_ERROR_IS_FATAL ANY)

set(copyright ${PROJECT_BINARY_DIR}/packages/copyright)
file(WRITE ${copyright} "Copyright: 2026 The authors of tress

Licensed under the Apache License, Version 2.0, whose text is in
/usr/share/common-licenses/Apache-2.0.

The program has Chart.js in its pages: Copyright: Chart.js Contributors,
under the MIT license, as its first lines there say.
")

# tress_package(component NAME name SUMMARY text [DETAILS text] [DEPENDS packages] [SECTION section] [ARCHITECTURE all]
#   [POSTINST command] [PRERM command])
# What Python compiles on its way is no file of the package: commands after installation and before removal see to it.
macro(tress_package component)
  cmake_parse_arguments(ARG "" "NAME;SUMMARY;DETAILS;DEPENDS;SECTION;ARCHITECTURE;POSTINST;PRERM" "" ${ARGN})
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${ARG_NAME})
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "${ARG_SUMMARY}\n${ARG_DETAILS}")
  if(ARG_DEPENDS)
    set(CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS "${ARG_DEPENDS}")
  endif()
  if(ARG_SECTION)
    set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${ARG_SECTION})
  endif()
  if(ARG_ARCHITECTURE)
    set(CPACK_DEBIAN_${upper}_PACKAGE_ARCHITECTURE ${ARG_ARCHITECTURE})
    set(CPACK_DEBIAN_${upper}_PACKAGE_SHLIBDEPS OFF)
  endif()
  set(scripts)
  foreach(moment POSTINST PRERM)
    if(ARG_${moment})
      string(TOLOWER ${moment} script)
      set(script ${PROJECT_BINARY_DIR}/packages/${component}/${script})
      file(WRITE ${script} "#!/bin/sh\nset -e\n${ARG_${moment}}\n")
      list(APPEND scripts ${script})
    endif()
  endforeach()
  set(CPACK_DEBIAN_${upper}_PACKAGE_CONTROL_EXTRA ${scripts})
  install(FILES ${copyright} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${ARG_NAME} COMPONENT ${component})
  install(FILES ${changelog}.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${ARG_NAME} COMPONENT ${component})
endmacro()

set(soversion ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(libraries)
set(comma)
if(BUILD_SHARED_LIBS)
  set(libraries "libtress${soversion} (= ${PROJECT_VERSION})")
  set(comma ", ")
  tress_package(library NAME libtress${soversion} SECTION libs SUMMARY "scattering of elliptical hair, shared libraries"
    DETAILS "The learning service and the fiber model of tress, for other renderers.")
  file(WRITE ${PROJECT_BINARY_DIR}/packages/library/triggers "activate-noawait ldconfig\n")
  list(APPEND CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/packages/library/triggers)
  file(WRITE ${PROJECT_BINARY_DIR}/packages/library/libtress${soversion} "# Four libraries of one version, always used together.
libtress${soversion}: package-name-doesnt-match-sonames
# CPack writes these beside the trigger.
libtress${soversion}: maintscript-calls-ldconfig
")
  install(FILES ${PROJECT_BINARY_DIR}/packages/library/libtress${soversion} DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides
    COMPONENT library)
endif()
tress_package(program NAME tress DEPENDS "${libraries}" SUMMARY "renderer of hair and fur that learns its scattering tables"
  DETAILS "Renders grooms whose fibers have elliptical cross-sections, without a bake.")
tress_package(development NAME libtress-dev SECTION libdevel
  DEPENDS "${libraries}${comma}libtbb-dev, libhwy-dev, libglm-dev" SUMMARY "scattering of elliptical hair, development files"
  DETAILS "Headers, libraries and the files by which find_package(tress) finds them.")
if(TRESS_BUILD_PYTHON)
  math(EXPR next_python "${Python_VERSION_MINOR} + 1")  # a compiled module is for one Python
  tress_package(python NAME python3-tress SECTION python SUMMARY "renderer of hair and fur, for Python 3"
    DEPENDS "${libraries}${comma}python3 (>= 3.${Python_VERSION_MINOR}~), python3 (<< 3.${next_python}), python3-numpy"
    DETAILS "Grooms from numpy arrays, pictures as arrays."
    POSTINST "py3compile -p python3-tress" PRERM "py3clean -p python3-tress")
endif()
tress_package(blender NAME blender-tress ARCHITECTURE all DEPENDS "blender, tress (>= ${PROJECT_VERSION})"
  SUMMARY "renderer of hair and fur, as a render engine of Blender" DETAILS "An add-on that runs the program tress."
  PRERM "rm -rf /usr/share/blender/scripts/addons/tress_render/__pycache__")
if(TARGET tress-lab)
  install(TARGETS tress-lab RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT laboratory)
  if(BUILD_SHARED_LIBS)
    set_target_properties(tress-lab PROPERTIES INSTALL_RPATH "$ORIGIN/${from_program}")
  endif()
  add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/manual_laboratory/tress-lab.1 DEPENDS tress-lab
    COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/manual_laboratory
    COMMAND tress-lab help --man > ${PROJECT_BINARY_DIR}/manual_laboratory/tress-lab.1)
  add_custom_target(manual_laboratory ALL DEPENDS ${PROJECT_BINARY_DIR}/manual_laboratory/tress-lab.1)
  install(FILES ${PROJECT_BINARY_DIR}/manual_laboratory/tress-lab.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT laboratory)
  tress_package(laboratory NAME tress-lab DEPENDS "${libraries}" SUMMARY "laboratory of tress: the models and learners it is measured against"
    DETAILS "All commands of tress with the published rivals, and commands that measure one fiber.")
endif()
include(CPack)
