// The source that CMake wants beside precompiled headers.
#include <catch2/catch.hpp>
