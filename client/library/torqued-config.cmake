# torqued::client, a C++ client of torqued; torqued::lcmtypes, its messages.
include("${CMAKE_CURRENT_LIST_DIR}/find-lcm.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/torqued-targets.cmake")
