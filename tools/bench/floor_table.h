// bench/floor_table.h: what a disk itself can do, for `plait bench floors`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace plait::bench {

/// Measures each kind of floor, buffered and direct, by our own program and by fio. Returns an
/// object a floor: {directory, kind, direct, own, fio, agree}, or {..., failure}. Needs `bytes`
/// twice on the disk. Errors: kIo, kNoSpace for the directory. REQUIRES: one thread.
std::vector<nlohmann::ordered_json> measure_floors(const std::filesystem::path& directory,
                                                   std::uint64_t bytes, std::uint64_t block_bytes,
                                                   bool fio);
std::string floor_table(const std::vector<nlohmann::ordered_json>& floors);

}  // namespace plait::bench
