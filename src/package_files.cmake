# Before CPack packs: manual pages are compressed, as Debian has them, and programs and libraries look for shared libraries
# where the system does, not beside themselves or in the build folder.
cmake_policy(VERSION 3.25)
file(GLOB_RECURSE files LIST_DIRECTORIES OFF ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/*)
foreach(file ${files})
  if(file MATCHES "/share/man/.*[.]1$")
    execute_process(COMMAND gzip -9n ${file} COMMAND_ERROR_IS_FATAL ANY)
  elseif(file MATCHES "/usr/bin/|[.]so([.0-9]*)$" AND NOT IS_SYMLINK ${file})
    file(RPATH_REMOVE FILE ${file})
  endif()
endforeach()
