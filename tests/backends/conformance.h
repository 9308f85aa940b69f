// tests/backends/conformance.h: the specification of a backend, as a suite that is run over every
// one of them. A new backend is done when it passes.
//
// A test program links conformance.cpp and defines backends_under_test().
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "plait/backend.h"
#include "support/temporary_directory.h"

namespace plait::test {

struct BackendUnderTest {
  std::string label;
  BackendRegistry::Entry entry;
  std::string pipeline = "none";
};

/// What the suite runs over.
const std::vector<BackendUnderTest>& backends_under_test();

/// The geometry of a level, as small as a test wants it.
struct LevelShape {
  std::uint64_t edge_count = 70;  ///< five blocks, the last one not full
  std::vector<EdgeId> border_edges = {};
  int level = 3;
  std::size_t record_bytes = 12;
  std::uint64_t block_bytes = 4096;
};

/// One level in a directory of its own, with the table that a store would keep.
class LevelUnderTest {
 public:
  explicit LevelUnderTest(const BackendUnderTest& subject, LevelShape shape = {});

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
  const BackendUnderTest& subject_;
  LevelShape shape_;
  TemporaryDirectory directory_;
  Directory opened_;  ///< for durable backends
  LevelGeometry geometry_;
  BlockTable table_;
  std::string name_;
  std::unique_ptr<Volume> volume_;
  std::unique_ptr<Backend> backend_;
};

enum class Content { kZeros, kSmooth, kRandom };

/// `bytes` bytes that compress very well, well, or not at all.
std::vector<std::byte> make_content(std::size_t bytes, Content content, std::uint32_t seed);

/// The bytes of these blocks as the backend reads them.
std::vector<std::byte> read_blocks(Backend& backend, const LevelGeometry& geometry,
                                   BlockRange blocks);

}  // namespace plait::test
