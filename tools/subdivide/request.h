// tools/subdivide/request.h: what somebody asks of a subdivision. Values that were not given are
// left open: an earlier run that is resumed, or what suits the rest, decides them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "plait/options.h"

namespace plait {

struct SubdivisionRequest {
  std::filesystem::path mesh;
  std::filesystem::path store;  ///< may be empty where the backend keeps nothing
  int levels = 1;               ///< the level to reach, counted from the mesh

  // What an earlier run has decided already, and a request may only repeat.
  std::optional<std::string> backend, codec, filter, layout, scheme, precision;
  std::optional<std::uint64_t> block_bytes, max_slot_bytes;

  std::string executor = "auto";
  std::uint64_t memory_bytes = StoreOptions().budget_bytes;
  int threads = 1;
  bool normals = false;
  bool limit = false;
  bool durable = true;
  bool digest = false;
  bool force = false;
  bool resume = false;
  bool ignore_size = false;  ///< begin although memory or disk are too small
};

}  // namespace plait
