// CMake needs at least one source for a target with precompiled headers.
#include <nlohmann/json.hpp>
