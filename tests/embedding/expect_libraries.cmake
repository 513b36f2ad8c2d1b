# That a program has loaded the shared libraries of tress from below a folder. Stops with what it has loaded where not.
function(expect_libraries program folder)
  execute_process(COMMAND ldd ${program} OUTPUT_VARIABLE loaded ERROR_VARIABLE loaded)
  foreach(library base adaptive fiber)
    if(NOT loaded MATCHES "${folder}[^ ]*/libtress_${library}\\.so")
      message(FATAL_ERROR "expected libtress_${library}.so of ${folder} among what ${program} loads, found\n${loaded}")
    endif()
  endforeach()
endfunction()
