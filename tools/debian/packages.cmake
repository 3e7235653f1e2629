# Debian packages of the components torqued, torquectl and client, by cpack: what a package has beside what cmake --install
# installs. tools/package configures a tree for this.

if(NOT CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  message(FATAL_ERROR "TORQUED_PACKAGES is set, and CMAKE_INSTALL_PREFIX is \"${CMAKE_INSTALL_PREFIX}\"; packages go to /usr")
endif()

if("$ENV{SOURCE_DATE_EPOCH}" STREQUAL "")
  message(FATAL_ERROR "TORQUED_PACKAGES is set, and SOURCE_DATE_EPOCH, the date that is in the packages, is not: tools/package sets it")
endif()

set(package_torqued torqued)
set(package_torquectl torquectl)
set(package_client libtorqued-client-dev)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_COMPONENTS_ALL torqued torquectl client)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_SET_DESTDIR ON) # or what goes to /etc would go to that of this machine
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
                                                WORLD_EXECUTE) # whatever the umask

# 1~deb12 is older than 1~deb13, so that a new release's package follows the old one's; and than 1, of one without number
set(TORQUED_REVISION 1 CACHE STRING "The packages' revision, which grows when the same version is packaged anew")
file(STRINGS /etc/os-release release REGEX "^(ID|VERSION_ID)=")
set(CPACK_DEBIAN_PACKAGE_RELEASE ${TORQUED_REVISION})
if(release MATCHES "VERSION_ID=\"?([0-9.]+)")
  set(number ${CMAKE_MATCH_1})
  string(REGEX MATCH "(^|;)ID=\"?([a-z]+)" id "${release}")
  string(REGEX REPLACE "^debian$" "deb" id "${CMAKE_MATCH_2}")
  string(APPEND CPACK_DEBIAN_PACKAGE_RELEASE "~${id}${number}")
endif()
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)

# who gives packages to others says who answers for them
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "the authors of torqued <torqued@example.org>")
if(DEFINED ENV{DEBFULLNAME} AND DEFINED ENV{DEBEMAIL})
  set(CPACK_DEBIAN_PACKAGE_MAINTAINER "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
endif()
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "") # each description begins with its own
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)

set(CPACK_DEBIAN_TORQUED_PACKAGE_NAME ${package_torqued})
set(CPACK_DEBIAN_TORQUED_PACKAGE_SECTION science)
set(CPACK_DEBIAN_TORQUED_PACKAGE_RECOMMENDS torquectl)
set(CPACK_DEBIAN_TORQUED_PACKAGE_CONTROL_EXTRA "")
foreach(file IN ITEMS postinst prerm postrm)
  list(APPEND CPACK_DEBIAN_TORQUED_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_LIST_DIR}/${file})
endforeach()
set(CPACK_COMPONENT_TORQUED_DESCRIPTION "joint torques of a planar biped, on LCM: the daemon
torqued hears desired joint states of a planar biped on LCM, and answers each
with the joint torques that produce it and the ground reactions of both feet.

The services torqued and torqued@NAME are there after the installation, and
run when they are told to: systemctl enable --now torqued")

set(CPACK_DEBIAN_TORQUECTL_PACKAGE_NAME ${package_torquectl})
set(CPACK_DEBIAN_TORQUECTL_PACKAGE_SOURCE torqued)
set(CPACK_DEBIAN_TORQUECTL_PACKAGE_SECTION science)
set(CPACK_DEBIAN_TORQUECTL_PACKAGE_SUGGESTS "torqued, liblcm-bin")
set(CPACK_COMPONENT_TORQUECTL_DESCRIPTION "joint torques of a planar biped, on LCM: the tool
torquectl makes up walks, sends motions to torqued, shows what it answers,
live and from recordings of lcm-logger (package liblcm-bin), and computes the
same without a daemon. Measured walking is in /usr/share/torqued/trajectories.")

set(CPACK_DEBIAN_CLIENT_PACKAGE_NAME ${package_client})
set(CPACK_DEBIAN_CLIENT_PACKAGE_SOURCE torqued)
set(CPACK_DEBIAN_CLIENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_CLIENT_PACKAGE_DEPENDS liblcm-dev)
set(CPACK_DEBIAN_CLIENT_PACKAGE_SUGGESTS "torqued, torquectl")
set(CPACK_COMPONENT_CLIENT_DESCRIPTION "joint torques of a planar biped, on LCM: clients of one's own
The C++ library torqued::client, for CMake and pkg-config, with an example;
and the messages: definitions, and what C++, Python and lcm-spy need.")
install(FILES ${CMAKE_CURRENT_LIST_DIR}/lintian-overrides DESTINATION /usr/share/lintian/overrides RENAME ${package_client}
        COMPONENT client)

# the service's configuration is the user's: an upgrade asks before it touches what was changed
set(configuration /etc/torqued)
install(FILES ${PROJECT_SOURCE_DIR}/service/systemd/torqued.toml DESTINATION ${configuration} COMPONENT torqued)
file(WRITE ${PROJECT_BINARY_DIR}/debian/conffiles "${configuration}/torqued.toml\n")
list(APPEND CPACK_DEBIAN_TORQUED_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/conffiles)

# SOURCE_DATE_EPOCH, where it is set
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(WRITE ${PROJECT_BINARY_DIR}/debian/changelog.Debian
     "torqued (${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) unstable; urgency=medium

  * Packages of torqued ${PROJECT_VERSION}; what is new in it is in changelog.gz.

 -- ${CPACK_DEBIAN_PACKAGE_MAINTAINER}  ${date}
")
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  set(documents /usr/share/doc/${package_${component}})
  install(FILES ${CMAKE_CURRENT_LIST_DIR}/copyright ${PROJECT_BINARY_DIR}/debian/changelog.Debian DESTINATION ${documents}
          COMPONENT ${component})
  install(FILES ${PROJECT_SOURCE_DIR}/CHANGELOG.md DESTINATION ${documents} RENAME changelog COMPONENT ${component})
  # after all else of the component, because this file is included last
  install(CODE "
    set(share \"\$ENV{DESTDIR}/usr/share\")
    file(GLOB compressed \"\${share}/doc/*/changelog*\" \"\${share}/man/man*/*\")
    execute_process(COMMAND gzip --best --no-name --force \${compressed} COMMAND_ERROR_IS_FATAL ANY)
    file(GLOB archives \"\${share}/java/*.jar\")
    if(archives)
      execute_process(COMMAND strip-nondeterminism --timestamp=$ENV{SOURCE_DATE_EPOCH} \${archives} COMMAND_ERROR_IS_FATAL ANY)
    endif()" COMPONENT ${component})
endforeach()

include(CPack)
