// Checks of levels that are files: opening again, damage, refusals.
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <utility>

#include "conformance/suite.h"
#include "io/file_operations.h"

namespace plait::conformance {
namespace {

/// Opens the level and reads all of it.
std::optional<ErrorCode> error_of_reading(LevelUnderTest& level, CheckLog& log,
                                          OpenMode mode = OpenMode::kRead) {
  try {
    read_all(level.open(mode), level.geometry());
  } catch (const Error& error) {
    log.expect(std::string_view(error.what()).find(level.file().native()) != std::string_view::npos,
               "the message of an error names the file");
    return error.code();
  }
  return std::nullopt;
}

Bytes write_and_close(LevelUnderTest& level, Content content) {
  Backend& backend = level.open();
  Bytes bytes = write_all(backend, level.geometry(), content, 3);
  backend.sync(true);
  level.close();
  return bytes;
}

Bytes stored(const LevelUnderTest& level, const BlockEntry& entry) {
  Bytes bytes(entry.stored_bytes);
  File(level.file(), OpenMode::kRead).read_at(entry.offset, bytes);
  return bytes;
}

void overwrite(const LevelUnderTest& level, std::uint64_t offset, const Bytes& bytes) {
  File(level.file(), OpenMode::kReadWrite).write_at(offset, bytes);
}

/// While it lives, every file operation in a directory fails as on a full disk.
class FullDisk final : public FileOperationHook {
 public:
  explicit FullDisk(std::filesystem::path directory) : directory_(std::move(directory)) {
    set_file_operation_hook(this);
  }
  ~FullDisk() { set_file_operation_hook(nullptr); }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

  /// Whether anything was written with plait::File, or by calls of the hook.
  bool was_asked() const { return asked_; }

 private:
  Verdict before(const FileOperation& operation) noexcept override {
    if (!operation.path.native().starts_with(directory_.native())) return {};
    asked_ = true;
    return {ENOSPC};
  }
  void after(const FileOperation&) noexcept override {}

  std::filesystem::path directory_;
  std::atomic<bool> asked_ = false;
};

}  // namespace

void check_reopening(const Subject& subject, CheckLog& log) {
  for (const Content content : {Content::kZeros, Content::kSmooth, Content::kRandom}) {
    log.at(to_string(content));
    LevelUnderTest level(subject, {37, {0, 3, 30}, 3, 24, 4096});
    Bytes bytes = write_and_close(level, content);
    Backend& reader = level.open(OpenMode::kRead);
    log.expect(read_all(reader, level.geometry()) == bytes,
               "a level that is opened for reading has its bytes");
    log.expect(reader.stored_bytes() > 0, "stored_bytes() of a written level is not 0");
    reader.sync(true);

    Backend& writer = level.open(OpenMode::kReadWrite);
    log.expect(read_all(writer, level.geometry()) == bytes,
               "a level that is opened for writing has its bytes");
    const Bytes fresh = make_content(level.geometry().block_bytes(1), Content::kRandom, 9);
    writer.write({1, 1}, fresh);
    writer.sync(true);
    std::ranges::copy(
        fresh, bytes.begin() + static_cast<std::ptrdiff_t>(level.geometry().block_offset(1)));
    log.expect(read_all(level.open(OpenMode::kRead), level.geometry()) == bytes,
               "a block that was written after opening has its new bytes");
  }
}

void check_modes(const Subject& subject, CheckLog& log) {
  LevelUnderTest level(subject);
  log.expect(error_of_reading(level, log) == ErrorCode::kNotFound,
             "a level that does not exist cannot be read (kNotFound)");
  log.expect(error_of_reading(level, log, OpenMode::kReadWrite) == ErrorCode::kNotFound,
             "a level that does not exist cannot be opened for writing (kNotFound)");
  log.expect(!std::filesystem::exists(level.file()), "a refused open_level() makes no file");
  write_and_close(level, Content::kSmooth);
  log.expect(error_of_reading(level, log, OpenMode::kCreate).has_value(),
             "a level that exists is not created again");
  log.expect(!error_of_reading(level, log),
             "an attempt to create a level again leaves it as it was");
}

void check_read_only(const Subject& subject, CheckLog& log) {
  LevelUnderTest level(subject);
  write_and_close(level, Content::kSmooth);
  Backend& backend = level.open(OpenMode::kRead);
  const BlockEntry before = level.table()[0];
  const Bytes bytes(level.geometry().block_bytes(0));
  log.expect(error_of(log,
                      [&] {
                        backend.write({0, 1}, bytes);
                      }) == ErrorCode::kBadState,
             "a level that was opened for reading refuses write() (kBadState)");
  log.expect(level.table()[0].checksum == before.checksum,
             "a refused write() leaves the table as it was");
  log.expect(!error_of_reading(level, log), "a refused write() leaves the file as it was");
}

void check_flipped_bit(const Subject& subject, CheckLog& log) {
  for (const Content content : {Content::kSmooth, Content::kRandom}) {
    LevelUnderTest level(subject);
    write_and_close(level, content);
    const std::uint64_t last = level.geometry().block_count() - 1;
    for (const std::uint64_t block : {std::uint64_t{0}, last}) {
      const BlockEntry& entry = level.table()[block];
      const Bytes good = stored(level, entry);
      for (const std::size_t place : {std::size_t{0}, good.size() / 2, good.size() - 1}) {
        log.at(std::string(to_string(content)) + ", byte " + std::to_string(place) + " of block " +
               std::to_string(block));
        Bytes bad = good;
        bad[place] ^= std::byte{0x10};
        overwrite(level, entry.offset, bad);
        log.expect(error_of_reading(level, log) == ErrorCode::kCorruption,
                   "a flipped bit of a stored block is found (kCorruption)");
      }
      overwrite(level, entry.offset, good);
      log.expect(!error_of_reading(level, log), "a block whose bytes are whole again can be read");
    }
  }
}

void check_swapped_blocks(const Subject& subject, CheckLog& log) {
  LevelUnderTest level(subject);
  write_and_close(level, Content::kRandom);  // stored raw everywhere, so of one size
  const BlockEntry first = level.table()[0], second = level.table()[1];
  log.require(first.stored_bytes == second.stored_bytes,
              "blocks that no codec shortens take their raw size");
  const Bytes first_bytes = stored(level, first), second_bytes = stored(level, second);
  overwrite(level, first.offset, second_bytes);
  overwrite(level, second.offset, first_bytes);
  log.expect(error_of_reading(level, log) == ErrorCode::kCorruption,
             "two blocks that changed places are found (kCorruption)");

  level.table().entries()[0].checksum = second.checksum;
  level.table().entries()[1].checksum = first.checksum;
  log.expect(error_of_reading(level, log) == ErrorCode::kCorruption,
             "a checksum belongs to the number of its block: two blocks that changed places "
             "together with their checksums are found (kCorruption)");
}

void check_file_cut_short(const Subject& subject, CheckLog& log) {
  LevelUnderTest level(subject);
  write_and_close(level, Content::kRandom);
  std::uint64_t end = 0;
  for (const BlockEntry& entry : std::as_const(level.table()).entries())
    end = std::max(end, entry.offset + entry.stored_bytes);
  for (const std::uint64_t bytes : {end - 1, end / 2, std::uint64_t{0}}) {
    log.at(std::to_string(bytes) + " of " + std::to_string(end) + " bytes are left");
    std::filesystem::resize_file(level.file(), bytes);
    log.expect(error_of_reading(level, log) == ErrorCode::kCorruption,
               "a file that was cut short is found when it is read (kCorruption)");
    log.expect(error_of_reading(level, log, OpenMode::kReadWrite) == ErrorCode::kCorruption,
               "a file that was cut short is found when it is opened for writing (kCorruption)");
  }
}

void check_file_cut_while_open(const Subject& subject, CheckLog& log) {
  LevelUnderTest level(subject);
  write_and_close(level, Content::kRandom);
  Backend& backend = level.open(OpenMode::kRead);
  std::filesystem::resize_file(level.file(), 0);
  for (std::uint64_t block = 0; block < level.geometry().block_count(); ++block) {
    log.expect(error_of(log,
                        [&] {
                          read_blocks(backend, level.geometry(), {block, 1});
                        })
                   .has_value(),
               "read() of a file that was cut short while it was open fails");
    if (subject.entry.traits.maps_for_reading)
      log.expect(error_of(log, [&] { backend.address(block); }).has_value(),
                 "address() in a file that was cut short while it was open fails");
  }
}

// Blocks are whole pages, so that each is one write, which fails as a whole.
void check_failed_write(const Subject& subject, CheckLog& log) {
  LevelUnderTest level(subject, {16, {}, 5, 16, 16 << 10});
  const LevelGeometry& geometry = level.geometry();
  Backend& backend = level.open();
  const Bytes before = write_all(backend, geometry, Content::kRandom, 3),
              other = make_content(geometry.block_bytes(1), Content::kRandom, 4);
  std::optional<ErrorCode> error;
  {
    const FullDisk full(level.directory().path());
    error = error_of(log, [&] { backend.write({1, 1}, other); });
    if (!full.was_asked())
      return log.leave_out(
          "the backend writes without plait::File, so no write can be made "
          "to fail");
  }
  log.expect(error.has_value(), "a write that the system refuses is an error");
  log.expect(read_all(backend, geometry) == before,
             "a write that failed leaves all blocks as they were");
}

void check_bad_entries(const Subject& subject, CheckLog& log) {
  LevelUnderTest level(subject);
  write_and_close(level, Content::kSmooth);
  const BlockEntry good = level.table()[1];
  std::vector<std::pair<const char*, BlockEntry>> bad = {
      {"the largest offset", good},       {"an offset near the largest", good},
      {"an offset four bytes off", good}, {"the offset of another block", good},
      {"a size of 4 GiB", good},          {"a size of 0", good},
      {"an unknown encoding", good}};
  bad[0].second.offset = ~std::uint64_t{0};
  bad[1].second.offset = ~std::uint64_t{0} - 511;
  bad[2].second.offset += 4;
  bad[3].second.offset = level.table()[0].offset;
  bad[4].second.stored_bytes = 0xffffffff;
  bad[5].second.stored_bytes = 0;
  bad[6].second.encoding = static_cast<BlockEncoding>(7);
  for (const auto& [what, entry] : bad) {
    log.at(what);
    level.table().entries()[1] = entry;
    log.expect(error_of_reading(level, log) == ErrorCode::kCorruption,
               "an entry of the table that cannot be is refused (kCorruption)");
  }
  log.at("");
  level.table().entries()[1] = good;
  log.expect(!error_of_reading(level, log), "the entry as it was is accepted");
}

}  // namespace plait::conformance
