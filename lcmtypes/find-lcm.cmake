# Finds LCM: target torqued::lcm. Installed, too, for those who use the client library.
#
# LCM 1.4 and newer bring a CMake package. Debian's LCM 1.3.1 brings none, and its pkg-config file asks for GLib's
# headers, which nothing here needs: there header and library are looked up one by one.

find_package(lcm CONFIG QUIET)
if(NOT TARGET torqued::lcm)
  add_library(torqued::lcm INTERFACE IMPORTED GLOBAL)
  if(TARGET lcm::lcm)
    target_link_libraries(torqued::lcm INTERFACE lcm::lcm)
  else()
    find_path(LCM_INCLUDE_DIR lcm/lcm-cpp.hpp)
    find_library(LCM_LIBRARY lcm)
    if(NOT LCM_INCLUDE_DIR OR NOT LCM_LIBRARY)
      message(FATAL_ERROR "LCM was not found: install liblcm-dev, or set CMAKE_PREFIX_PATH to where LCM is installed")
    endif()
    target_include_directories(torqued::lcm SYSTEM INTERFACE ${LCM_INCLUDE_DIR})
    target_link_libraries(torqued::lcm INTERFACE ${LCM_LIBRARY})
  endif()
endif()
