// The directory in which a part is made.
#pragma once

#include <cstdint>
#include <string>

#include "plait/detail/namespace.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The names of the directories in which this machine makes a part begin with it.
std::string own_prefix(std::uint32_t part);

/// The directory of a part that is being made. The destructor removes it unless the part is
/// complete. A lock (flock) tells other processes of this machine that it is in use.
class PartDirectory {
 public:
  PartDirectory(const Directory& plan, std::uint32_t part);
  ~PartDirectory();
  PartDirectory(const PartDirectory&) = delete;
  PartDirectory& operator=(const PartDirectory&) = delete;

  const Directory& made() const { return made_; }
  const std::string& name() const { return name_; }
  void keep() { is_kept_ = true; }

  /// Removes the files of a part, and the directory if it has no others.
  static void remove(const Directory& plan, const std::string& name) noexcept;

 private:
  const Directory& plan_;
  std::string name_;
  Directory made_;
  bool is_kept_ = false;
};

PLAIT_END_NAMESPACE
