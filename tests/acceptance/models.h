// tests/acceptance/models.h: the real meshes, and how much of the tests to run.
#pragma once

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>

namespace plait::test {

/// Closed and open, of genus 0 to 43, of one and of 26 components, valences 2 to 26.
constexpr std::string_view kModels[] = {"deo_like", "bunny",           "bunny_open",
                                        "koala",    "lysozyme_waters", "spot"};

inline std::filesystem::path model_path(std::string_view name) {
  return std::filesystem::path(PLAIT_MODELS_DIRECTORY) / (std::string(name) + ".ply");
}

/// False, with a warning, where the mesh is absent: the test is then to be skipped.
inline bool has_model(std::string_view name) {
  if (std::filesystem::exists(model_path(name))) return true;
  WARN("no " << model_path(name) << ": skipped");
  return false;
}

/// PLAIT_ACCEPTANCE=full: hours instead of minutes.
inline bool is_full_run() {
  const char* value = std::getenv("PLAIT_ACCEPTANCE");
  return value != nullptr && std::string_view(value) == "full";
}

}  // namespace plait::test
