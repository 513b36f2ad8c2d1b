# The renderer: everything that is not installed for others to embed, and the program.
tress_library(tress_image KIND STATIC INCLUDES src FOLDERS src/image LINK tress_adaptive glm::glm PRIVATE OpenEXR::OpenEXR stb fmt::fmt)

tress_library(tress_denoise KIND STATIC INCLUDES src FOLDERS src/denoise LINK tress_image glm::glm PRIVATE TBB::tbb fmt::fmt)

tress_library(tress_scene KIND STATIC INCLUDES src FOLDERS src/scene/model src/scene/generate src/scene/read src/scene/read/grooms
  LINK tress_fiber tress_image glm::glm PRIVATE nlohmann_json::nlohmann_json fmt::fmt ZLIB::ZLIB PkgConfig::lz4)

tress_library(tress_geometry KIND STATIC INCLUDES src FOLDERS src/geometry LINK tress_scene PRIVATE embree TBB::tbb)

tress_library(tress_integrate KIND STATIC INCLUDES src FOLDERS src/integrate LINK tress_geometry tress_image tress_denoise
  PRIVATE TBB::tbb HEADERS nlohmann_json::nlohmann_json)
# Alone, so that what it calls can be replaced when a program is linked (bench/image/recorded_paths.h).
set_source_files_properties(src/integrate/path_tracer.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)

# tress_web_assets(TARGET NAMESPACE HEADER files...): the files as bytes of the program, by web_assets() of the namespace.
function(tress_web_assets target namespace header)
  set(files)
  foreach(file ${ARGN})
    cmake_path(ABSOLUTE_PATH file BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
    list(APPEND files ${file})
  endforeach()
  list(JOIN files "," names)
  set(output ${PROJECT_BINARY_DIR}/generated/${target}_web_assets.cpp)
  add_custom_command(OUTPUT ${output} DEPENDS ${files} ${PROJECT_SOURCE_DIR}/src/live/web/embed.cmake
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${output} -DNAMESPACE=${namespace} -DHEADER=${header} -DFILES=${names}
      -P ${PROJECT_SOURCE_DIR}/src/live/web/embed.cmake VERBATIM)
  target_sources(${target} PRIVATE ${output})
endfunction()

tress_library(tress_live KIND STATIC INCLUDES src FOLDERS src/live LINK tress_integrate nlohmann_json::nlohmann_json
  PRIVATE fmt::fmt PkgConfig::httplib)
# The pages and the chart library that they use, as bytes of the program: no file and no network is needed when it runs.
find_file(CHART_JS chart.min.js PATHS /usr/share/javascript/chart.js /usr/share/nodejs/chart.js/dist REQUIRED)
configure_file(${CHART_JS} ${PROJECT_BINARY_DIR}/generated/web/chart.js COPYONLY)
file(GLOB web_files CONFIGURE_DEPENDS src/live/web/*.html src/live/web/*.css src/live/web/*.js)
tress_web_assets(tress_live tress::live live/web_page.h ${web_files} ${PROJECT_BINARY_DIR}/generated/web/chart.js)

tress_library(tress_farm KIND STATIC INCLUDES src FOLDERS src/farm LINK tress_base PRIVATE nlohmann_json::nlohmann_json fmt::fmt)

tress_library(tress_cli KIND STATIC INCLUDES src FOLDERS src/cli src/cli/farm LINK tress_integrate tress_live tress_farm
  PRIVATE stb CLI11::CLI11 spdlog::spdlog fmt::fmt nlohmann_json::nlohmann_json TBB::tbb)
foreach(library scene integrate live cli)
  compile_together(tress_${library} 10)
endforeach()
# What tress --version prints: the commit at every build, the libraries found here.
add_custom_target(tress_commit BYPRODUCTS ${PROJECT_BINARY_DIR}/generated/tress_commit.h COMMAND ${CMAKE_COMMAND}
  -DSOURCE=${PROJECT_SOURCE_DIR} -DOUTPUT=${PROJECT_BINARY_DIR}/generated/tress_commit.h -P ${PROJECT_SOURCE_DIR}/src/cli/commit.cmake)
add_dependencies(tress_cli tress_commit)
target_include_directories(tress_cli PRIVATE ${PROJECT_BINARY_DIR}/generated)
string(CONCAT libraries "Embree ${embree_VERSION}, OpenEXR ${OpenEXR_VERSION}, oneTBB ${TBB_VERSION}, Highway ${hwy_VERSION}, "
  "Eigen ${Eigen3_VERSION}, fmt ${fmt_VERSION}, spdlog ${spdlog_VERSION}, CLI11 ${CLI11_VERSION}, nlohmann-json ${nlohmann_json_VERSION}")
set_source_files_properties(src/cli/commands.cpp PROPERTIES COMPILE_DEFINITIONS "TRESS_LIBRARIES=\"${libraries}\"")
add_executable(tress src/main.cpp)
target_link_libraries(tress PRIVATE tress_cli tress_flags)
target_include_directories(tress PRIVATE src)
