# Makes a Debian package of a finished build: bash docker/package.sh deb
# Beside what `cmake --install` copies it contains the systemd units, their user, and /etc/multitetra.
set(DEBIAN_FOLDER ${CMAKE_CURRENT_LIST_DIR})
set(PACKAGED ${PROJECT_BINARY_DIR}/packaged)
file(MAKE_DIRECTORY ${PACKAGED})
configure_file(${DEBIAN_FOLDER}/changelog.in ${PACKAGED}/changelog.Debian @ONLY)

# multitetra_debian(...): installs like install(), in the Debian package alone.
function(multitetra_debian)
  install(${ARGV} COMPONENT debian EXCLUDE_FROM_ALL)
endfunction()
set(doc share/doc/multitetra)
multitetra_debian(CODE "
  set(doc \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${doc})
  file(MAKE_DIRECTORY \${doc})
  execute_process(COMMAND gzip -9nc ${PROJECT_SOURCE_DIR}/CHANGELOG.md OUTPUT_FILE \${doc}/changelog.gz COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND gzip -9nc ${PACKAGED}/changelog.Debian OUTPUT_FILE \${doc}/changelog.Debian.gz COMMAND_ERROR_IS_FATAL ANY)
  execute_process(
    COMMAND python3 ${PROJECT_SOURCE_DIR}/docker/contents.py bill ${PROJECT_SOURCE_DIR} \${doc}/sbom.cdx.json
            ${PROJECT_BINARY_DIR} COMMAND_ERROR_IS_FATAL ANY)
")
multitetra_debian(FILES ${DEBIAN_FOLDER}/copyright DESTINATION ${doc})
multitetra_debian(FILES ${DEBIAN_FOLDER}/server.toml DESTINATION /etc/multitetra PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ)
file(READ ${PROJECT_SOURCE_DIR}/docker/multitetra.service unit)
string(REPLACE /usr/local/bin /usr/bin unit "${unit}")
file(WRITE ${PACKAGED}/multitetra.service "${unit}")
string(REPLACE "server serve --config /etc/multitetra/server.toml" "gateway --config /etc/multitetra/gateway.toml"
       gateway_unit "${unit}")
string(REPLACE "Multi-Tetra streaming server" "Multi-Tetra streaming gateway" gateway_unit "${gateway_unit}")
file(WRITE ${PACKAGED}/multitetra-gateway.service "${gateway_unit}")
multitetra_debian(FILES ${PACKAGED}/multitetra.service ${PACKAGED}/multitetra-gateway.service DESTINATION lib/systemd/system)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME multitetra)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_CMAKE_PROJECTS
    "${PROJECT_BINARY_DIR};multitetra;ALL;/;${PROJECT_BINARY_DIR};multitetra;debian;/")
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
