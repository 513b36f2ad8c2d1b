# The laboratory: the paper's rivals, models and learners, and tress-lab, the program that has them. Never installed with
# tress and never linked into it.
tress_library(tress_references KIND STATIC INCLUDES bench FOLDERS bench/references bench/references/models bench/references/learners
  LINK tress_fiber PRIVATE hwy::hwy HEADERS Eigen3::Eigen)
target_include_directories(tress_references PRIVATE ${PROJECT_SOURCE_DIR}/adaptive)
compile_together(tress_references 8)

tress_library(tress_laboratory KIND STATIC INCLUDES bench FOLDERS bench/lab LINK tress_cli tress_references
  PRIVATE stb CLI11::CLI11 fmt::fmt nlohmann_json::nlohmann_json TBB::tbb
  HEADERS Eigen3::Eigen)
tress_web_assets(tress_laboratory tress::lab lab/web_assets.h bench/lab/web/lobes.html bench/lab/web/lobes.js)
compile_together(tress_laboratory 10)
add_dependencies(tress_laboratory tress_commit)
target_include_directories(tress_laboratory PRIVATE ${PROJECT_BINARY_DIR}/generated)

add_executable(tress-lab bench/tress_lab.cpp)
set_target_properties(tress-lab PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bench)
target_link_libraries(tress-lab PRIVATE tress_laboratory tress_flags)
target_include_directories(tress-lab PRIVATE ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/bench)
