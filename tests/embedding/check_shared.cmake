# Builds and installs the libraries as shared ones, builds the project beside this file against them, and runs what it
# made. cmake -DSOURCE=... -DWORK=... -DGENERATOR=... -DCOMPILER=... -DLAUNCHER=... -DFLAGS=... -P check_shared.cmake
include(${CMAKE_CURRENT_LIST_DIR}/expect_libraries.cmake)
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status OUTPUT_VARIABLE said ERROR_VARIABLE said)
  if(NOT status EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "${said}\n${command}: ${status}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
set(prefix ${WORK}/prefix)
set(common -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}
  -DCMAKE_CXX_FLAGS=${FLAGS} -DCMAKE_BUILD_TYPE=Release -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF)
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/libraries ${common} -DBUILD_SHARED_LIBS=ON -DTRESS_BUILD_TESTS=OFF
  -DTRESS_BUILD_BENCH=OFF)
run(${CMAKE_COMMAND} --build ${WORK}/libraries --target tress_base tress_adaptive tress_fiber)
run(${CMAKE_COMMAND} --install ${WORK}/libraries --prefix ${prefix} --component development)
run(${CMAKE_COMMAND} --install ${WORK}/libraries --prefix ${prefix} --component library)
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/build ${common} -DCMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${WORK}/build)
expect_libraries(${WORK}/build/fiber ${prefix})
run(${WORK}/build/service ${WORK}/beam.cache)
run(${WORK}/build/fiber)
file(REMOVE_RECURSE ${WORK})
