// Damaged blocks of a refined surface, decoded by the pipelines of the presets: the decoder fills
// exactly the block or refuses, twice with the same result. Its memory follows from the geometry of
// the level, and it takes no more than ten times as long as for the whole block.
//
// Input: preset, attribute, mesh, level, block, and a way to damage the stored bytes: 0 changes
// single bytes, and the rest of the input are pairs of a place (2 bytes) and a value; 1 does the
// same behind a cut (2 bytes); 2 takes the rest as the stored bytes.
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "bounded_work.h"
#include "chosen.h"
#include "compressed/block_coder.h"
#include "input_bytes.h"
#include "oracle.h"
#include "plait/compression.h"
#include "small_levels.h"

using namespace plait;
using namespace plait::fuzz;

namespace {

constexpr std::array kPresets = {"fast", "default", "small"};
constexpr std::uint64_t kSeal = 0x0123'4567'89ab'cdef;

/// A block of a level, as the preset stores it.
struct Encoded {
  std::vector<std::byte> stored;  ///< as long as the block if it is stored raw
  double seconds = 0;
};

/// A level with its coder, which all inputs share.
class Level {
 public:
  Level(std::size_t preset, std::size_t attribute, SmallLevels& levels, int level)
      : levels_(levels), attribute_(attribute), level_(level) {
    pipeline_ = preset_pipeline(kPresets[preset], levels.schema(attribute));
    filters_ = default_pipelines().open(pipeline_, levels.filter_level(attribute, level)).filters;
    if (need_other_blocks(filters_)) seal_ = kSeal;
  }

  const LevelGeometry& geometry() const { return levels_.geometry(attribute_, level_); }
  std::span<const std::byte> raw(std::uint64_t block) {
    return levels_.block(attribute_, level_, block);
  }
  std::size_t seal_bytes() const { return seal_ ? sizeof kSeal : 0; }

  /// A coder that has coded nothing yet.
  BlockCoder coder() const {
    return {default_pipelines().make_codec(pipeline_.codec), geometry().max_block_bytes(),
            std::min<std::size_t>(filters_.size(), 2), scratch_bytes(filters_)};
  }
  bool decode(BlockCoder& coder, std::uint64_t block, const ContextBytes& context,
              std::span<const std::byte> stored, std::span<std::byte> raw) {
    return accepts({ErrorCode::kCorruption}, [&] {
      const std::span<std::byte> buffer = coder.stored_buffer(stored.size());
      std::ranges::copy(stored, buffer.begin());
      coder.decode({filters_, {block, context.spans(), {}}, seal_}, buffer, raw);
    });
  }
  ContextBytes context_of(std::uint64_t block) {
    return filters_.empty() ? ContextBytes() : ContextBytes(*filters_.front(), levels_, block);
  }

  const Encoded& encoded(std::uint64_t block) {
    const auto [found, is_new] = encoded_.try_emplace(block);
    Encoded& made = found->second;
    if (!is_new) return made;
    BlockCoder one = coder();
    const ContextBytes context = context_of(block);
    const EncodedBlock bytes =
        one.encode({filters_, {block, context.spans(), {}}, seal_}, raw(block));
    made.stored.assign(bytes.bytes.begin(), bytes.bytes.end());
    if (bytes.encoding == BlockEncoding::kRaw) return made;
    ExactBytes back(raw(block).size());
    made.seconds =
        fastest(10, [&] { require(decode(one, block, context, made.stored, back.span())); });
    require(std::ranges::equal(back.span(), raw(block)));
    return made;
  }

 private:
  SmallLevels& levels_;
  std::size_t attribute_;
  int level_;
  Pipeline pipeline_;
  Filters filters_;
  std::optional<std::uint64_t> seal_;
  std::map<std::uint64_t, Encoded> encoded_;
};

Level& shared_level(std::size_t preset, std::size_t attribute, std::size_t mesh, int level) {
  static std::map<std::size_t, std::unique_ptr<SmallLevels>> surfaces;
  auto& surface = surfaces[mesh];
  if (!surface)
    surface =
        refined_levels(small_mesh(mesh % kSmallMeshes),
                       mesh < kSmallMeshes ? ComponentType::kFloat32 : ComponentType::kFloat64);
  static std::map<std::tuple<std::size_t, std::size_t, std::size_t, int>, Level> all;
  const auto key = std::tuple(preset, attribute, mesh, level);
  const auto found = all.find(key);
  if (found != all.end()) return found->second;
  return all.try_emplace(key, preset, attribute, *surface, level).first->second;
}

std::vector<std::byte> damaged(InputBytes& input, const Level& level,
                               std::span<const std::byte> whole) {
  const std::size_t way = input.take_below(3);
  std::vector<std::byte> stored(whole.begin(), whole.end());
  if (way == 2) {
    stored.resize(std::min(stored.size(), level.seal_bytes()));
    stored.insert(stored.end(), input.rest().begin(), input.rest().end());
    return stored;
  }
  if (way == 1) stored.resize(std::min<std::size_t>(stored.size(), input.take<std::uint16_t>()));
  while (!input.rest().empty() && !stored.empty()) {
    const std::size_t at = input.take<std::uint16_t>();
    stored[at % stored.size()] ^= input.take<std::byte>();
  }
  return stored;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  InputBytes input(data, size);
  const std::size_t preset = take_choice(input, kPresets), attribute = input.take_below(2),
                    mesh = input.take_below(2 * kSmallMeshes);
  const int number = static_cast<int>(1 + input.take_below(SmallLevels::kFinest));
  Level& level = shared_level(preset, attribute, mesh, number);
  const std::uint64_t block = input.take<std::uint8_t>() % level.geometry().block_count();
  const std::size_t raw_bytes = level.geometry().block_bytes(block);
  const Encoded& whole = level.encoded(block);
  if (whole.seconds == 0) return 0;  // too small to be encoded
  std::vector<std::byte> bytes = damaged(input, level, whole.stored);
  // The backend refuses entries of a table with more.
  bytes.resize(std::min<std::size_t>(bytes.size(), max_encoded_bytes(raw_bytes)));
  ExactBytes stored(bytes), raw(raw_bytes), again(raw_bytes);
  const ContextBytes context = level.context_of(block);

  BlockCoder coder = level.coder();
  bool decoded = false;
  require_memory(coder.memory_bytes(),
                 [&] { decoded = level.decode(coder, block, context, stored.span(), raw.span()); });
  // A decoder that leaves a part of its buffers as they were would now fill it with other bytes.
  require(level.decode(coder, block, context, whole.stored, again.span()));
  require(std::ranges::equal(again.span(), level.raw(block)));
  bool decoded_again = false;
  require_time(whole.seconds, [&] {
    decoded_again = level.decode(coder, block, context, stored.span(), again.span());
  });
  require(decoded_again == decoded);
  require(!decoded || std::ranges::equal(raw.span(), again.span()));
  if (bytes == whole.stored) require(std::ranges::equal(raw.span(), level.raw(block)));
  return 0;
}
