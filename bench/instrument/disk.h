// bench/instrument/disk.h: which disk is under a directory, and what it counts.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace plait::instrument {

/// What the system says of the disk under a directory. A text that is not known is empty.
struct DiskFacts {
  std::filesystem::path directory;
  std::string file_system;  ///< "ext4"
  std::string mount_point, mount_options, source;
  std::string device;     ///< the kernel's name of the block device: "vda"; empty without one
  std::string scheduler;  ///< "none", "mq-deadline"
  std::string model;
  std::uint64_t read_ahead_bytes = 0;
  bool rotational = false;
  bool in_memory = false;  ///< tmpfs or ramfs: reads never come from a disk
  std::uint64_t bytes = 0, free_bytes = 0;

  /// "ext4 on vda", "tmpfs".
  std::string name() const;
};
/// Errors: kNotFound, kIo.
DiskFacts disk_facts(const std::filesystem::path& directory);
nlohmann::ordered_json to_json(const DiskFacts& facts);

/// Bytes that a disk read and wrote.
struct Traffic {
  bool known = false;
  std::uint64_t bytes_read = 0, bytes_written = 0;
};
Traffic operator-(const Traffic& after, const Traffic& before);
/// Of the block device, for all programs together (/sys/dev/block/M:N/stat).
Traffic device_traffic(const DiskFacts& facts);
/// For this process and its children that have ended (/proc/self/io): a second opinion, and what
/// remains where there is no block device.
Traffic process_traffic();

/// How many bytes a measurement may use in `directory`: what is free less a tenth of the disk.
std::uint64_t usable_bytes(const DiskFacts& facts);
/// Throws kNoSpace unless it may use `bytes`.
void require_space(const std::filesystem::path& directory, std::uint64_t bytes);

}  // namespace plait::instrument
