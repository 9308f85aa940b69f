// CMake needs at least one source for a target with precompiled headers.
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
