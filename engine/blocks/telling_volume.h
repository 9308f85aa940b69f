// blocks/telling_volume.h: a volume that does something in another way than its backend says.
#pragma once

#include <string>
#include <vector>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A volume may also be one of these. Safe from any thread.
class TellingVolume {
 public:
  virtual ~TellingVolume() = default;
  /// One line for each thing.
  virtual std::vector<std::string> notices() const = 0;
};

PLAIT_END_NAMESPACE
