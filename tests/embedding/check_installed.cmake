# Installs BUILD into a prefix of its own, builds the project beside this file against it, and runs what it made.
# Renders every scene that is installed.
# cmake -DBUILD=... -DWORK=... -DGENERATOR=... -DCOMPILER=... -DLAUNCHER=... -DFLAGS=... -P check_installed.cmake
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status OUTPUT_VARIABLE said ERROR_VARIABLE said)
  message(STATUS "${said}")
  if(NOT status EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "${command}: ${status}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
set(prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
run(${prefix}/bin/tress --version)
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/build -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${prefix}
  -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER} -DCMAKE_CXX_FLAGS=${FLAGS}
  -DCMAKE_BUILD_TYPE=Release -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF)
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/service ${WORK}/beam.cache)
run(${WORK}/build/service ${WORK}/beam.cache)
run(${prefix}/bin/tress cache verify ${WORK}/beam.cache)
run(${WORK}/build/fiber)

# What is installed of the scenes is all that they need: each renders, small, from the prefix.
file(GLOB scenes ${prefix}/share/tress/scenes/*.json)
list(FILTER scenes EXCLUDE REGEX "/schema.json$")
list(LENGTH scenes count)
if(count LESS 10)
  message(FATAL_ERROR "only ${count} scenes in ${prefix}/share/tress/scenes")
endif()
foreach(scene ${scenes})
  run(${prefix}/bin/tress render ${scene} -o ${WORK}/scene.exr --resolution 16x16 --spp 1 --quiet)
endforeach()
file(REMOVE_RECURSE ${WORK})
