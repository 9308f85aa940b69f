// backends/conformance/level.h: one level as a store would have it, for checks of a backend.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "plait/extend/backend.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/codec.h"

namespace plait::conformance {

struct Subject {
  std::string label = {};
  RegisteredBackend entry = {};
  Pipeline pipeline = {};
  /// Makes the codec of `pipeline`. Empty: the checks of codecs are left out.
  std::function<std::unique_ptr<Codec>()> make_codec = {};
  int codec_blocks = 4000;  ///< that each of these checks codes
  /// The levels are in new directories below this one. Empty: the machine's for temporary files.
  std::filesystem::path directory = {};
};

/// The geometry of a level, as small as a check wants it.
struct LevelShape {
  std::uint64_t edge_count = 70;  ///< five blocks, the last one not full
  std::vector<EdgeId> border_edges = {};
  int level = 3;
  std::size_t record_bytes = 12;
  std::uint64_t block_bytes = 4096;
};

/// A new directory, which the destructor removes.
class ScratchDirectory {
 public:
  explicit ScratchDirectory(const std::filesystem::path& parent);
  ~ScratchDirectory();
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// One level in a directory of its own, with the table that a store would keep.
class LevelUnderTest {
 public:
  explicit LevelUnderTest(const Subject& subject, LevelShape shape = {});

  /// Closes what was open before.
  Backend& open(OpenMode mode = OpenMode::kCreate);
  void close() {
    backend_.reset();
    volume_.reset();
  }

  const LevelGeometry& geometry() const { return geometry_; }
  BlockTable& table() { return table_; }
  /// As in a store whose attribute number 2 has the level.
  const std::string& name() const { return name_; }
  std::filesystem::path file() const { return directory_.path() / name_; }
  const Directory& directory() const { return opened_; }

 private:
  const Subject& subject_;
  LevelShape shape_;
  ScratchDirectory directory_;
  Directory opened_;  ///< for durable backends
  LevelGeometry geometry_;
  BlockTable table_;
  std::string name_;
  std::unique_ptr<Volume> volume_;
  std::unique_ptr<Backend> backend_;
};

enum class Content : std::uint8_t { kZeros, kSmooth, kRandom };
const char* to_string(Content content);

using Bytes = std::vector<std::byte>;

/// `bytes` bytes that compress very well, well, or not at all.
Bytes make_content(std::size_t bytes, Content content, std::uint32_t seed);

/// The bytes of these blocks as the backend reads them.
Bytes read_blocks(Backend& backend, const LevelGeometry& geometry, BlockRange blocks);
Bytes read_all(Backend& backend, const LevelGeometry& geometry);
/// Writes the whole level in one call, and returns its bytes.
Bytes write_all(Backend& backend, const LevelGeometry& geometry, Content content,
                std::uint32_t seed = 1);
/// The bytes of one block out of those of the level.
Bytes part(const Bytes& bytes, const LevelGeometry& geometry, std::uint64_t block);

}  // namespace plait::conformance
