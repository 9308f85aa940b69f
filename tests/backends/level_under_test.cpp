#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <utility>

#include "backends/conformance.h"

namespace plait::test {
namespace {

StoreUuid test_uuid() {
  StoreUuid uuid;
  for (std::size_t i = 0; i < uuid.size(); ++i) uuid[i] = static_cast<std::byte>(17 * i + 1);
  return uuid;
}

}  // namespace

LevelUnderTest::LevelUnderTest(const BackendUnderTest& subject, LevelShape shape)
    : subject_(subject),
      shape_(std::move(shape)),
      geometry_(SlotShapes(shape_.edge_count, EdgeSet(shape_.border_edges)),
                BaseRelativeLevel(shape_.level), shape_.record_bytes, shape_.block_bytes),
      table_(test_uuid(), 2, shape_.level, geometry_.block_count()),
      name_("attribute2.level" + std::string(shape_.level < 10 ? "0" : "") +
            std::to_string(shape_.level) + ".1") {}

Backend& LevelUnderTest::open(OpenMode mode) {
  close();
  if (subject_.entry.traits.durable && !opened_.is_open()) opened_ = Directory(directory_.path());
  volume_ = subject_.entry.open({});
  backend_ = volume_->open_level({opened_, name_, mode, geometry_, table_, 4, subject_.pipeline});
  return *backend_;
}

std::vector<std::byte> make_content(std::size_t bytes, Content content, std::uint32_t seed) {
  std::vector<std::byte> result(bytes);
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

std::vector<std::byte> read_blocks(Backend& backend, const LevelGeometry& geometry,
                                   BlockRange blocks) {
  // Filled with something else than zeros, so that a block left alone is seen.
  std::vector<std::byte> bytes(geometry.range_bytes(blocks.first, blocks.count), std::byte{0xa5});
  backend.read(blocks, bytes);
  return bytes;
}

}  // namespace plait::test
