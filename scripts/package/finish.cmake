# Run by cpack before it packs the staged files: what Debian's policy asks for, with bytes that depend on nothing
# but the sources and SOURCE_DATE_EPOCH.
if(CPACK_COMPONENTS_ALL STREQUAL "python")
  return()
endif()
set(usr ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/usr)
if(NOT IS_DIRECTORY ${usr})
  set(usr ${CPACK_TEMPORARY_DIRECTORY}/usr)
endif()

set(date $ENV{SOURCE_DATE_EPOCH})
if(NOT date)
  string(TIMESTAMP date %s UTC)
endif()
execute_process(COMMAND date --utc --rfc-email --date=@${date} OUTPUT_VARIABLE stamp OUTPUT_STRIP_TRAILING_WHITESPACE
                COMMAND_ERROR_IS_FATAL ANY)
file(WRITE ${usr}/share/doc/qerr/changelog.Debian
     "qerr (${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) unstable; urgency=medium\n\n"
     "  * What changes for users: qerr help changes.\n\n -- ${CPACK_PACKAGE_CONTACT}  ${stamp}\n")

file(GLOB_RECURSE texts ${usr}/share/man/*.[17] ${usr}/share/doc/qerr/changelog.Debian)
list(SORT texts)
if(texts)
  execute_process(COMMAND gzip --best --no-name --force ${texts} COMMAND_ERROR_IS_FATAL ANY)
endif()

# The folder that Debian's zsh searches.
file(RENAME ${usr}/share/zsh/site-functions ${usr}/share/zsh/vendor-completions)

file(GLOB_RECURSE archives ${usr}/lib/*.a)
list(SORT archives)
foreach(archive ${archives})
  execute_process(COMMAND strip --strip-debug --remove-section=.comment --remove-section=.note
                          --enable-deterministic-archives ${archive} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
