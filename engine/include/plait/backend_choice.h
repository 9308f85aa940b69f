// plait/backend_choice.h: a backend that was chosen for a new store, and the reason in words.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace plait {

struct BackendChoice {
  std::string name;
  std::string reason;  ///< one clause, with the figures or the refusal that decided
};

/// Chooses for a store at `path` whose levels have `raw_bytes` before compression.
using BackendChooser =
    std::function<BackendChoice(const std::filesystem::path& path, std::uint64_t raw_bytes)>;

}  // namespace plait
