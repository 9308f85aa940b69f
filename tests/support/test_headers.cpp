// CMake needs at least one source for a target with precompiled headers.
#include <catch2/catch.hpp>
