#include "conformance/level.h"

#include <stdlib.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <random>
#include <system_error>
#include <utility>

#include "plait/error.h"

namespace plait::conformance {
namespace {

StoreUuid any_uuid() {
  StoreUuid uuid;
  for (std::size_t i = 0; i < uuid.size(); ++i) uuid[i] = static_cast<std::byte>(17 * i + 1);
  return uuid;
}

}  // namespace

ScratchDirectory::ScratchDirectory(const std::filesystem::path& parent) {
  std::string name =
      ((parent.empty() ? std::filesystem::temp_directory_path() : parent) / "plait-level-XXXXXX")
          .string();
  if (::mkdtemp(name.data()) == nullptr) throw system_error("make", name, errno);
  path_ = name;
}

ScratchDirectory::~ScratchDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

LevelUnderTest::LevelUnderTest(const Subject& subject, LevelShape shape)
    : subject_(subject),
      shape_(std::move(shape)),
      directory_(subject.directory),
      geometry_(SlotShapes(shape_.edge_count, EdgeSet(shape_.border_edges)),
                BaseRelativeLevel(shape_.level), shape_.record_bytes, shape_.block_bytes),
      table_(any_uuid(), 2, shape_.level, geometry_.block_count()),
      name_("attribute2.level" + std::string(shape_.level < 10 ? "0" : "") +
            std::to_string(shape_.level) + ".1") {}

Backend& LevelUnderTest::open(OpenMode mode) {
  close();
  if (subject_.entry.traits.durable && !opened_.is_open()) opened_ = Directory(directory_.path());
  volume_ = subject_.entry.open({});
  const AttributeSchema schema;
  backend_ =
      volume_->open_level({opened_, name_, mode, geometry_, table_, schema, subject_.pipeline});
  return *backend_;
}

const char* to_string(Content content) {
  switch (content) {
    case Content::kZeros:
      return "zeros";
    case Content::kSmooth:
      return "smooth content";
    case Content::kRandom:
      break;
  }
  return "random content";
}

Bytes make_content(std::size_t bytes, Content content, std::uint32_t seed) {
  Bytes result(bytes);
  if (content == Content::kRandom) {
    std::mt19937 random(seed);
    std::ranges::generate(result, [&] { return static_cast<std::byte>(random() & 0xff); });
  }
  if (content == Content::kSmooth) {
    for (std::size_t i = 0; i + 4 <= bytes; i += 4) {
      const auto x = static_cast<float>(i + seed);
      const float value = 3.0f + std::sin(x * 1e-4f);
      std::memcpy(result.data() + i, &value, 4);
    }
  }
  return result;
}

Bytes read_blocks(Backend& backend, const LevelGeometry& geometry, BlockRange blocks) {
  // Filled with something else than zeros, so that a block left alone is seen.
  Bytes bytes(geometry.range_bytes(blocks.first, blocks.count), std::byte{0xa5});
  backend.read(blocks, bytes);
  return bytes;
}

Bytes read_all(Backend& backend, const LevelGeometry& geometry) {
  return read_blocks(backend, geometry, {0, geometry.block_count()});
}

Bytes write_all(Backend& backend, const LevelGeometry& geometry, Content content,
                std::uint32_t seed) {
  Bytes bytes = make_content(geometry.total_bytes(), content, seed);
  backend.write({0, geometry.block_count()}, bytes);
  return bytes;
}

Bytes part(const Bytes& bytes, const LevelGeometry& geometry, std::uint64_t block) {
  const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(geometry.block_offset(block));
  return {first, first + static_cast<std::ptrdiff_t>(geometry.block_bytes(block))};
}

}  // namespace plait::conformance
