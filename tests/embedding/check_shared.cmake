# Builds and installs the libraries alone, as shared ones that export nothing but ours, builds the project beside this file against them, and runs what it
# made. cmake -DSOURCE=... -DWORK=... -DGENERATOR=... -DCOMPILER=... -DLAUNCHER=... -DFLAGS=... -P check_shared.cmake
include(${CMAKE_CURRENT_LIST_DIR}/expect_libraries.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

# Runs the hosts in C11 and C++17.
function(run_c_hosts folder)
  run(${folder}/fiber_in_c ${WORK}/fiber.cache)
  run(${folder}/service_in_c ${WORK}/service.cache)
  run(${folder}/wrapper)
endfunction()

file(REMOVE_RECURSE ${WORK})
set(prefix ${WORK}/prefix)
set(common -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}
  -DCMAKE_CXX_FLAGS=${FLAGS} -DCMAKE_BUILD_TYPE=Release -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF)
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/libraries ${common} -DBUILD_SHARED_LIBS=ON -DTRESS_LIBRARIES_ONLY=ON)
run(${CMAKE_COMMAND} --build ${WORK}/libraries)
run(${CMAKE_COMMAND} --install ${WORK}/libraries --prefix ${prefix})
expect_own_symbols(${prefix})
foreach(other bin share/man share/blender share/tress)
  if(EXISTS ${prefix}/${other})
    message(FATAL_ERROR "expected the libraries alone, found ${prefix}/${other}")
  endif()
endforeach()
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/build ${common} -DCMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${WORK}/build)
expect_libraries(${WORK}/build/fiber ${prefix})
run(${WORK}/build/service ${WORK}/beam.cache)
run(${WORK}/build/fiber)
run_c_hosts(${WORK}/build)
file(REMOVE_RECURSE ${WORK})
