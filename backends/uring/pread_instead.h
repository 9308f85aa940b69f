// backends/uring/pread_instead.h: the files of "uring" by explicit reads and writes, where there is
// no io_uring: the files are the same.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "blocks/telling_volume.h"
#include "built_in_backends.h"
#include "plait/error.h"
#include "plait/extend/backend.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class PreadInstead final : public Volume, public TellingVolume {
 public:
  PreadInstead(const VolumeSpec& volume, const Error& reason)
      : volume_(open_each_level(open_pread_backend)(volume)),
        notice_(std::string(reason.what()) + "; using pread instead, whose files are the same") {}

  std::unique_ptr<Backend> open_level(const LevelSpec& level) override {
    return volume_->open_level(level);
  }
  std::vector<std::string> notices() const override { return {notice_}; }

 private:
  std::unique_ptr<Volume> volume_;
  std::string notice_;
};

PLAIT_END_NAMESPACE
