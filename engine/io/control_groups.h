// io/control_groups.h: the cgroups of this process, and what they let it have.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Where Linux tells of cgroups.
struct ControlGroupFiles {
  std::filesystem::path groups = "/proc/self/cgroup", mounted = "/sys/fs/cgroup";
};

struct ControlGroup {
  std::filesystem::path directory;  ///< may not exist: a container does not see all groups
  bool is_version_2 = false;
};

/// The groups that can limit what `controller` ("memory", "cpu") counts: the group of this process
/// and all that contain it, of version 1 and of version 2.
std::vector<ControlGroup> control_groups(std::string_view controller,
                                         const ControlGroupFiles& files = {});

/// The processors that this process may use: those of the calling thread's affinity, at most as
/// many as the quotas of its cgroups last for, rounded up, and as SLURM_CPUS_PER_TASK says. 1 to
/// 1024. Pinned by tests/engine/io/machine_test.cpp.
int usable_processors(const ControlGroupFiles& files = {});

PLAIT_END_NAMESPACE
