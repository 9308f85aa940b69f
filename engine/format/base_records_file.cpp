#include "format/base_records_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <utility>

#include "base/number_type.h"
#include "format/number_places.h"
#include "format/packed_frame.h"
#include "format/planes.h"
#include "mesh/narrowing.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Records without noise may be larger than their frame by this factor, or be so small that nobody
/// minds. Those that follow the positions are as many as these, so they may be anything.
constexpr std::size_t kMostOfRecords = 64, kSmallRecords = 64u << 10;

constexpr double Vector3<double>::*kOfPositions[] = {&Vector3<double>::x, &Vector3<double>::y,
                                                     &Vector3<double>::z};

/// The words of the components of one type.
template <class Word>
struct Integers {
  using Of = Word;
  static Of word(Word bits) { return bits; }
  static Word bits(Of word) { return word; }
  static Of of_position(double /*x*/) { return 0; }
};
template <class Number>
struct Floats {
  using Of = WordOf<Number>;
  static Of word(Of bits) { return place_of(std::bit_cast<Number>(bits)); }
  static Of bits(Of word) { return std::bit_cast<Of>(number_at<Number>(word)); }
  static Of of_position(double x) {
    return place_of(static_cast<Number>(sizeof(Number) == 4 ? as_float32(x) : x));
  }
};

template <class Work>
void with_words(ComponentType type, Work work) {
  if (type == ComponentType::kFloat32) return work(Floats<float>());
  if (type == ComponentType::kFloat64) return work(Floats<double>());
  switch (component_bytes(type)) {
    case 1:
      return work(Integers<std::uint8_t>());
    case 2:
      return work(Integers<std::uint16_t>());
    case 4:
      return work(Integers<std::uint32_t>());
    default:
      return work(Integers<std::uint64_t>());
  }
}

/// Calls visit(planes of a component, what its words are predicted from, its first byte).
template <class Words, class Visit>
void for_each_component(const AttributeSchema& schema, std::span<const Vector3<double>> positions,
                        std::size_t count, Visit visit) {
  using Word = typename Words::Of;
  const bool follows = follows_base_positions(schema);
  for (std::size_t component = 0; component < schema.components; ++component)
    visit(Planes<Word>(count), component, [&, component](std::size_t v, Word before) {
      return follows ? Words::of_position(positions[v].*kOfPositions[component]) : before;
    });
}

bool is_refused(const AttributeSchema& schema, std::size_t stored, std::size_t records) {
  return !follows_base_positions(schema) && records > kSmallRecords &&
         records / kMostOfRecords > stored;
}

}  // namespace

bool follows_base_positions(const AttributeSchema& schema) {
  return schema.name == "position" && holds_points(schema);
}

std::vector<std::byte> encode_base_records(const AttributeSchema& schema,
                                           std::span<const std::byte> records,
                                           std::span<const Vector3<double>> positions) {
  const std::size_t record_bytes = schema.record_bytes(), count = records.size() / record_bytes;
  std::vector<std::byte> planes(records.size()), file;
  with_words(schema.type, [&]<class Words>(Words) {
    using Word = typename Words::Of;
    std::byte* to = planes.data();
    for_each_component<Words>(
        schema, positions, count, [&](Planes<Word> plane, std::size_t component, auto predict) {
          Word before = 0;
          for (std::size_t v = 0; v < count; ++v) {
            Word bits;
            std::memcpy(&bits, &records[v * record_bytes + component * sizeof bits], sizeof bits);
            const Word word = Words::word(bits);
            plane.put(to, v, zigzag(static_cast<Word>(word - predict(v, before))));
            before = word;
          }
          to += plane.bytes();
        });
  });
  append_frame(file, planes, "base records");
  if (file.size() < records.size() && !is_refused(schema, file.size(), records.size()) &&
      !is_bomb(file.size(), records.size()))
    return file;
  return {records.begin(), records.end()};
}

std::optional<std::string> decode_base_records(const AttributeSchema& schema,
                                               std::span<const std::byte> stored,
                                               std::span<const Vector3<double>> positions,
                                               std::span<std::byte> records) {
  if (stored.size() == records.size()) {
    std::ranges::copy(stored, records.begin());
    return std::nullopt;
  }
  if (is_refused(schema, stored.size(), records.size()))
    return fmt::format("{} bytes for records of {}, expected at least 1/{}", stored.size(),
                       records.size(), kMostOfRecords);
  std::string reason;
  const auto planes = take_frame(stored, records.size(), reason);
  if (!planes) return reason;
  if (!stored.empty()) return fmt::format("{} bytes after the frame, expected none", stored.size());
  const std::size_t record_bytes = schema.record_bytes(), count = records.size() / record_bytes;
  with_words(schema.type, [&]<class Words>(Words) {
    using Word = typename Words::Of;
    const std::byte* from = planes.get();
    for_each_component<Words>(
        schema, positions, count, [&](Planes<Word> plane, std::size_t component, auto predict) {
          Word before = 0;
          plane.for_each(from, [&](std::size_t v, Word difference) {
            before = static_cast<Word>(predict(v, before) + from_zigzag(difference));
            const Word bits = Words::bits(before);
            std::memcpy(&records[v * record_bytes + component * sizeof bits], &bits, sizeof bits);
          });
          from += plane.bytes();
        });
  });
  return std::nullopt;
}

PLAIT_END_NAMESPACE
