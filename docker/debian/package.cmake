# Makes a Debian package of a finished build: bash docker/package.sh deb
# It contains the programs, viewer, man pages, completion, the systemd unit, its user, and /etc/multitetra.
include(GNUInstallDirs)

set(DEBIAN_FOLDER ${CMAKE_CURRENT_LIST_DIR})
set(PACKAGED ${PROJECT_BINARY_DIR}/packaged)
file(MAKE_DIRECTORY ${PACKAGED})
set(doc usr/share/doc/multitetra)
configure_file(${DEBIAN_FOLDER}/changelog.in ${PACKAGED}/changelog.Debian @ONLY)

foreach(program multitetra_server_program multitetra_gateway_program multitetra_client_program multitetra_load_program)
  install(TARGETS ${program} RUNTIME DESTINATION usr/bin)
  # An installed program finds its viewer relative to itself: bin/../share.
endforeach()
# A short name for the most common command, `multitetra view`.
install(CODE "file(CREATE_LINK multitetra-server \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/usr/bin/multitetra SYMBOLIC)")
install(DIRECTORY ${PROJECT_BINARY_DIR}/share/multitetra DESTINATION usr/share PATTERN "*.sources" EXCLUDE)
foreach(program client gateway load server)
  install(FILES ${DEBIAN_FOLDER}/completion.bash DESTINATION usr/share/bash-completion/completions RENAME multitetra-${program})
endforeach()
install(FILES ${DEBIAN_FOLDER}/completion.bash DESTINATION usr/share/bash-completion/completions RENAME multitetra)
# Generates man pages from --help-all (requires help2man). Compresses files as Debian requires, reproducibly.
install(CODE "
  set(man \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/usr/share/man/man1)
  set(doc \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${doc})
  file(MAKE_DIRECTORY \${man} \${doc})
  foreach(program client gateway load server)
    execute_process(
      COMMAND help2man --no-info --help-option=--help-all --source=Multi-Tetra
              --name \"remote visualization of regular volume data\" ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/multitetra-\${program}
      COMMAND gzip -9nc OUTPUT_FILE \${man}/multitetra-\${program}.1.gz COMMAND_ERROR_IS_FATAL ANY)
  endforeach()
  file(CREATE_LINK multitetra-server.1.gz \${man}/multitetra.1.gz SYMBOLIC)
  execute_process(COMMAND gzip -9nc ${PROJECT_SOURCE_DIR}/CHANGELOG.md OUTPUT_FILE \${doc}/changelog.gz COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND gzip -9nc ${PACKAGED}/changelog.Debian OUTPUT_FILE \${doc}/changelog.Debian.gz COMMAND_ERROR_IS_FATAL ANY)
")
install(FILES ${DEBIAN_FOLDER}/copyright DESTINATION ${doc})
install(FILES ${DEBIAN_FOLDER}/server.toml DESTINATION etc/multitetra PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ)
file(READ ${PROJECT_SOURCE_DIR}/docker/multitetra.service unit)
string(REPLACE /usr/local/bin /usr/bin unit "${unit}")
file(WRITE ${PACKAGED}/multitetra.service "${unit}")
string(REPLACE "server serve --config /etc/multitetra/server.toml" "gateway --config /etc/multitetra/gateway.toml"
       gateway_unit "${unit}")
string(REPLACE "Multi-Tetra streaming server" "Multi-Tetra streaming gateway" gateway_unit "${gateway_unit}")
file(WRITE ${PACKAGED}/multitetra-gateway.service "${gateway_unit}")
install(FILES ${PACKAGED}/multitetra.service ${PACKAGED}/multitetra-gateway.service DESTINATION lib/systemd/system)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME multitetra)
set(CPACK_PACKAGING_INSTALL_PREFIX /)
set(CPACK_SET_DESTDIR OFF)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_CONTACT "Multi-Tetra maintainers <maintainers@multitetra.example>")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "adduser, ca-certificates")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "xdg-utils")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "remote visualization of regular volume data
 A server of isosurfaces of very large volumes: watertight, with topology kept
 and a certified error, coarse first and refined step by step. With a gateway,
 a client for the command line and a viewer for browsers.")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA
  "${DEBIAN_FOLDER}/conffiles;${DEBIAN_FOLDER}/postinst;${DEBIAN_FOLDER}/prerm;${DEBIAN_FOLDER}/postrm")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
