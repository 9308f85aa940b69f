// What plait join and plait-mpi say of a join.
#pragma once

#include <filesystem>

#include "plait/extend/parts.h"

namespace plait {

/// Parts are missing or bad (`plait join --help`).
constexpr int kExitIncomplete = 4;

/// Prints the digest of the store, or what is missing; with `json` an object. Returns the exit
/// status.
int report_join(const JoinResult& joined, const std::filesystem::path& plan,
                const std::filesystem::path& store, double seconds, bool json);
/// The same for parts that are not done, without a join.
int report_incomplete(const std::filesystem::path& plan, const JoinResult& parts, bool json);

}  // namespace plait
