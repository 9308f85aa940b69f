// plait/backend_choice.h: the backend that a program chose for a new store, and why.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "plait/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// The backend that choose_backend() chose, and why.
struct BackendChoice {
  std::string name;
  std::string reason;  ///< one clause with the reason: sizes, or why another one cannot be used
};

/// Chooses a backend for a new store at `path` whose levels have `raw_bytes` before compression.
using BackendChooser =
    std::function<BackendChoice(const std::filesystem::path& path, std::uint64_t raw_bytes)>;

PLAIT_END_NAMESPACE
