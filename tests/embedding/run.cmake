# Runs a command, whose output is then in `said`. Stops with it if the command fails.
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status OUTPUT_VARIABLE said ERROR_VARIABLE said)
  if(NOT status EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "${said}\n${command}: ${status}")
  endif()
  set(said "${said}" PARENT_SCOPE)
endfunction()
