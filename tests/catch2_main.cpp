// Catch2 v2 has no library with main().
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
