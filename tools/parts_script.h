// The script with which Slurm makes the parts of a plan.
#pragma once

#include <cstdint>
#include <filesystem>

namespace plait {

/// Writes a script for sbatch. An array has at most `longest` tasks. With more parts, the script is
/// given several times, each time with another --offset, as its head says. Errors: kInvalidArgument
/// if the file exists; kIo, kNoSpace.
void write_sbatch(const std::filesystem::path& script, const std::filesystem::path& plan,
                  std::uint32_t parts, std::uint32_t longest);

}  // namespace plait
