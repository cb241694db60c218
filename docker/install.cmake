# What `cmake --install` copies: the programs, the viewer, the demo volume, completion, and manual pages (if help2man is here).
# An installed program finds its viewer relative to itself: bin/../share.
include(GNUInstallDirs)

install(TARGETS multitetra_server_program multitetra_gateway_program multitetra_client_program multitetra_load_program)
# A short name for the most common command, `multitetra view`.
set(installed "\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}")
install(CODE "file(CREATE_LINK multitetra-server ${installed}/${CMAKE_INSTALL_BINDIR}/multitetra SYMBOLIC)")
install(DIRECTORY ${PROJECT_BINARY_DIR}/share/multitetra DESTINATION ${CMAKE_INSTALL_DATADIR} PATTERN "*.sources" EXCLUDE PATTERN "widget" EXCLUDE)
foreach(program multitetra multitetra-client multitetra-gateway multitetra-load multitetra-server)
  install(FILES ${CMAKE_CURRENT_LIST_DIR}/debian/completion.bash
          DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME ${program})
endforeach()

find_program(HELP2MAN help2man)
if(HELP2MAN)
  install(CODE "
    set(man ${installed}/${CMAKE_INSTALL_MANDIR}/man1)
    file(MAKE_DIRECTORY \${man})
    foreach(program client gateway load server)
      execute_process(
        COMMAND ${HELP2MAN} --no-info --help-option=--help-all --source=Multi-Tetra
                --name \"remote visualization of regular volume data\" ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/multitetra-\${program}
        COMMAND gzip -9nc OUTPUT_FILE \${man}/multitetra-\${program}.1.gz COMMAND_ERROR_IS_FATAL ANY)
    endforeach()
    file(CREATE_LINK multitetra-server.1.gz \${man}/multitetra.1.gz SYMBOLIC)
  ")
endif()
