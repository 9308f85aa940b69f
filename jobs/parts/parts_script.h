// The script with which Slurm makes the parts of a plan.
#pragma once

#include <cstdint>
#include <filesystem>

#include "io/unpublished.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A script for sbatch. An array has at most `longest` tasks. With more parts, the script is given
/// several times, each time with another --offset, as its head says. The constructor writes it
/// under a temporary name, and the destructor removes it if it was not published.
class SbatchScript {
 public:
  /// Errors: kInvalidArgument if the file exists; kNotFound if its directory does not; kIo,
  /// kNoSpace.
  SbatchScript(const std::filesystem::path& script, const std::filesystem::path& plan,
               std::uint32_t parts, std::uint32_t longest);
  /// Errors: those of UnpublishedFile::publish().
  void publish() { file_.publish(); }

 private:
  UnpublishedFile file_;
};

PLAIT_END_NAMESPACE
