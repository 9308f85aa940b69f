// bench/backends/floor_table.h: what a disk itself can do, for `plait bench floors`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace plait::bench {

constexpr int kFloorRounds = 5;

/// Measures each kind of floor, buffered and direct, by our own program and, where it has the same
/// pattern, by fio: five rounds. Returns an object a floor: {disk, kind, direct, own, fio, agree,
/// method, failure}; own and fio are {bytes_per_second, low, high, least, most, rounds} or null.
/// `before_each` is called before each measurement, and may throw. Needs `bytes` twice on the disk.
/// Errors: kIo, kNoSpace for the directory. REQUIRES: one thread.
std::vector<nlohmann::ordered_json> measure_floors(const std::filesystem::path& directory,
                                                   std::uint64_t bytes, std::uint64_t block_bytes,
                                                   bool fio,
                                                   const std::function<void()>& before_each);
/// Columns for a terminal.
std::string floor_table(const std::vector<nlohmann::ordered_json>& floors);

}  // namespace plait::bench
