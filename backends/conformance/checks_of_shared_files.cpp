// Checks of levels that are in one file.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "conformance/suite.h"

namespace plait::conformance {
namespace {

constexpr std::uint64_t kPageBytes = 4096;

/// A level of a file that has two.
struct SharedLevel {
  SharedLevel(int level, std::uint64_t first_byte_of_raw)
      : geometry(SlotShapes(37, EdgeSet(std::vector<EdgeId>{0, 3, 30})), BaseRelativeLevel(level),
                 24, 4096),
        table({}, 2, level, geometry.block_count()),
        first_byte(first_byte_of_raw) {}

  std::unique_ptr<Backend> open(Volume& volume, const Subject& subject, const Directory& directory,
                                OpenMode mode) {
    LevelSpec spec{directory, "both", mode, geometry, table, {}, subject.pipeline};
    spec.shares_file = true;
    if (subject.entry.traits.overwrites_in_place) spec.first_byte = first_byte;
    return volume.open_level(spec);
  }

  LevelGeometry geometry;
  BlockTable table;
  std::uint64_t first_byte;
  Bytes bytes = {};
};

}  // namespace

void check_shared_file(const Subject& subject, CheckLog& log) {
  for (const Content content : {Content::kSmooth, Content::kRandom}) {
    log.at(to_string(content));
    const ScratchDirectory scratch(subject.directory);
    const Directory directory(scratch.path());
    SharedLevel coarse(2, 0);
    SharedLevel fine(3, (coarse.geometry.total_bytes() + kPageBytes - 1) / kPageBytes * kPageBytes);
    std::uint64_t reported = 0;
    {
      const std::unique_ptr<Volume> volume = subject.entry.open({});
      const auto first = coarse.open(*volume, subject, directory, OpenMode::kCreate);
      coarse.bytes = make_content(coarse.geometry.total_bytes(), content, 1);
      first->write({0, 1}, part(coarse.bytes, coarse.geometry, 0));
      const auto second = fine.open(*volume, subject, directory, OpenMode::kCreate);
      fine.bytes = make_content(fine.geometry.total_bytes(), content, 2);
      // From the last block on, and the coarse level in between.
      for (std::uint64_t block = fine.geometry.block_count(); block-- > 0;) {
        second->write({block, 1}, part(fine.bytes, fine.geometry, block));
        if (block < coarse.geometry.block_count())
          first->write({block, 1}, part(coarse.bytes, coarse.geometry, block));
      }
      for (const auto* const level : {&first, &second}) {
        (*level)->sync(true);
        reported += (*level)->stored_bytes();
      }
    }
    log.expect(reported == std::filesystem::file_size(scratch.path() / "both") ||
                   subject.entry.traits.compressed,
               "stored_bytes() of the levels add up to the size of the file");
    const std::unique_ptr<Volume> volume = subject.entry.open({});
    for (SharedLevel* const level : {&coarse, &fine}) {
      const auto reader = level->open(*volume, subject, directory, OpenMode::kRead);
      log.expect(read_all(*reader, level->geometry) == level->bytes,
                 "each level in a shared file has its bytes");
    }
    log.expect(std::filesystem::file_size(scratch.path() / "both") + kPageBytes > reported,
               "stored_bytes() of the levels are not more than the file has");
  }
}

}  // namespace plait::conformance
