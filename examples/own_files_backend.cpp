// A plug-in in C++: the backend x-files, which is durable: it keeps each level in a file of the
// store's directory, block after block. A program takes it for a disk of its own, and changes
// read(), write() and sync(). The store makes versions of these files, so the backend need not: it
// is told which file is whose (LevelSpec::name), and overwrites blocks in their places.
//
//   plait subdivide mesh.ply s.plait --levels 4 --plugin ./own_files_backend.so --backend x-files
//   plait-conformance --plugin ./own_files_backend.so --backend x-files
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>

#include "plait/error.h"
#include "plait/extend/file.h"
#include "plait/extend/plugin_in_cpp.h"

namespace {
using plait::BlockRange, plait::Error, plait::ErrorCode, plait::LevelSpec, plait::OpenMode;

constexpr std::uint64_t kPage = 4096;

// One level of one attribute.
class FileBackend final : public plait::Backend {
 public:
  explicit FileBackend(const LevelSpec& level)
      : geometry_(level.geometry), table_(level.table), mode_(level.mode) {
    if (table_.size() != geometry_.block_count())
      throw Error(ErrorCode::kInvalidArgument,
                  level.path().native() + ": expected an entry for each block");
    // What a damaged store may claim is checked before anything is read.
    for (std::uint64_t block = 0; block < table_.size(); ++block)
      if (is_written(block) && table_[block].file == plait::kLevelFile &&
          (table_[block].encoding != plait::BlockEncoding::kRaw ||
           table_[block].offset != geometry_.block_offset(block) ||
           table_[block].stored_bytes != geometry_.block_bytes(block)))
        throw Error(ErrorCode::kCorruption,
                    level.path().native() + ": a block is not in its place");
    const std::uint64_t bytes = (geometry_.total_bytes() + kPage - 1) / kPage * kPage;
    file_ = plait::File(level.directory, level.name, mode_);
    if (mode_ == OpenMode::kCreate) {
      file_.resize(bytes);
      file_.preallocate(bytes);  // a full disk is an error now
    } else if (file_.size() != bytes) {
      throw Error(ErrorCode::kCorruption, level.path().native() + ": expected a file of " +
                                              std::to_string(bytes) + " bytes, found " +
                                              std::to_string(file_.size()));
    }
  }

  void read(BlockRange blocks, std::span<std::byte> into) override {
    check(blocks, into.size());
    for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block) {
      const std::span<std::byte> raw = into.first(geometry_.block_bytes(block));
      into = into.subspan(raw.size());
      if (!is_written(block)) {
        std::memset(raw.data(), 0, raw.size());
        continue;
      }
      file_.read_at(geometry_.block_offset(block), raw);
      table_.check(block, raw, file_.path());  // its checksum
    }
  }

  void write(BlockRange blocks, std::span<const std::byte> from) override {
    if (mode_ == OpenMode::kRead)
      throw Error(ErrorCode::kBadState, file_.path().native() + ": opened for reading");
    check(blocks, from.size());
    for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block) {
      const std::span<const std::byte> raw = from.first(geometry_.block_bytes(block));
      from = from.subspan(raw.size());
      file_.write_at(geometry_.block_offset(block), raw);
      table_.seal(block, geometry_.block_offset(block), plait::BlockEncoding::kRaw, raw);
    }
  }

  void advise(BlockRange, plait::Advice) noexcept override {}
  void sync(bool durable) override {
    if (durable) file_.sync();
  }
  std::uint64_t stored_bytes() const override {
    return (geometry_.total_bytes() + kPage - 1) / kPage * kPage;
  }

 private:
  bool is_written(std::uint64_t block) const {
    return table_[block].encoding != plait::BlockEncoding::kNeverWritten;
  }
  void check(BlockRange blocks, std::size_t bytes) const {
    if (blocks.first > table_.size() || blocks.count > table_.size() - blocks.first ||
        bytes != geometry_.range_bytes(blocks.first, blocks.count))
      throw Error(ErrorCode::kInvalidArgument, file_.path().native() + ": expected other blocks");
  }

  const plait::LevelGeometry& geometry_;
  plait::BlockTable& table_;
  OpenMode mode_;
  plait::File file_;
};

}  // namespace

extern "C" PLAIT_PLUGIN_EXPORT std::int32_t plait_plugin_v1(const plait_host* host) {
  return plait::add_in_cpp(host, [](plait::PluginRegistry& registry) {
    const auto open = [](const LevelSpec& level) { return std::make_unique<FileBackend>(level); };
    plait::RegisteredBackend backend{.name = "x-files",
                                     .summary = "a file for each level",
                                     .open = plait::open_each_level(open)};
    backend.traits.durable = true;
    backend.traits.overwrites_in_place = true;
    registry.add(std::move(backend));
  });
}
