# That libtress_c exports tress_* alone, and that hosts in C11 and C++17 build against its headers without a warning and
# run.
# cmake -DLIBRARY=... -DWORK=... -DCOMPILER=... -P check_c.cmake
include(${CMAKE_CURRENT_LIST_DIR}/expect_libraries.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

expect_c_symbols(${LIBRARY})
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
get_filename_component(folder ${LIBRARY} DIRECTORY)
set(include ${CMAKE_CURRENT_LIST_DIR}/../../include)
set(options -Wall -Wextra -Wpedantic -Werror -I${include})
set(link -L${folder} -Wl,-rpath,${folder} -ltress_c -lm)
foreach(program fiber service)
  run(cc -std=c11 ${options} ${CMAKE_CURRENT_LIST_DIR}/${program}.c -o ${WORK}/${program} ${link})
  run(${WORK}/${program} ${WORK}/${program}.cache)
endforeach()
run(${WORK}/fiber ${WORK}/fiber.cache)
foreach(program wrapper pbrt_hair)
  run(${COMPILER} -std=c++17 ${options} ${CMAKE_CURRENT_LIST_DIR}/${program}.cpp -o ${WORK}/${program} ${link})
  run(${WORK}/${program} ${WORK}/${program}.cache)
endforeach()

# A host without exceptions has the wrapper, too.
run(${COMPILER} -std=c++17 -fno-exceptions -fno-rtti ${options} -fsyntax-only ${CMAKE_CURRENT_LIST_DIR}/pbrt_hair.cpp)

# Settings of glm with which a vector is passed in another way than in the library are refused by the compiler.
foreach(setting GLM_FORCE_CTOR_INIT GLM_FORCE_SWIZZLE GLM_FORCE_DEFAULT_ALIGNED_GENTYPES)
  execute_process(COMMAND ${COMPILER} -std=c++20 -I${include} -D${setting} -DGLM_FORCE_INTRINSICS -fsyntax-only
    ${CMAKE_CURRENT_LIST_DIR}/fiber.cpp RESULT_VARIABLE result ERROR_VARIABLE message)
  if(result EQUAL 0 OR NOT message MATCHES "tress needs glm's")
    message(FATAL_ERROR "expected that ${setting} is refused, found: ${message}")
  endif()
endforeach()

# Rows without the library, from the cache that the example has saved: by the CUDA compiler where there is one.
find_program(nvcc nvcc PATHS /usr/local/cuda/bin)
set(frozen ${CMAKE_CURRENT_LIST_DIR}/frozen.cpp -I${include} -o ${WORK}/frozen)
run(${COMPILER} -std=c++11 ${options} ${frozen})
run(${WORK}/frozen ${WORK}/fiber.cache)
if(nvcc)
  run(${nvcc} -x cu -Werror all-warnings ${frozen})
  run(${WORK}/frozen ${WORK}/fiber.cache)
endif()

file(REMOVE_RECURSE ${WORK})
