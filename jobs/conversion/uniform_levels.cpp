#include "conversion/uniform_levels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <span>
#include <type_traits>
#include <vector>

#include "base/number_type.h"
#include "export/drawn_patch.h"
#include "export/patch_selection.h"
#include "plait/error.h"
#include "plait/extend/copy_levels.h"
#include "plait/extend/store_access.h"
#include "plait/patch_writer.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

template <class Number>
Number mean(Number a, Number b) {
  if constexpr (std::is_floating_point_v<Number>)
    return Number(0.5) * a + Number(0.5) * b;
  else
    return static_cast<Number>((a & b) + ((a ^ b) >> 1));
}

template <class Number>
Number get(std::span<const std::byte> bytes, std::size_t at) {
  Number number;
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

template <class Number>
void put(Number number, std::span<std::byte> bytes, std::size_t at) {
  std::memcpy(bytes.data() + at, &number, sizeof number);
}

/// Leaves a vector that has no direction.
template <class Real>
void make_unit(std::span<std::byte> vector) {
  std::array<double, 3> numbers{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    numbers[axis] = get<Real>(vector, axis * sizeof(Real));
  const double length = std::hypot(numbers[0], numbers[1], numbers[2]);
  if (!(length > 0) || !std::isfinite(length)) return;
  for (std::size_t axis = 0; axis < 3; ++axis)
    put(static_cast<Real>(numbers[axis] / length), vector, axis * sizeof(Real));
}

/// The grid of one face at the finest level, of one attribute.
class Grid {
 public:
  Grid(const AttributeSchema& schema, int levels)
      : schema_(schema),
        is_normal_(schema.name == "normal" && schema.components == 3),
        levels_(levels),
        size_(std::int64_t{1} << levels),
        records_(patch_vertex_count(size_) * schema.record_bytes()) {}

  std::span<const std::byte> records() const { return records_; }

  void fill(const DrawnPatch& patch) {
    const DrawnDepths& depths = patch.depths();
    const auto has = [&](int level, std::int64_t i, std::int64_t j) {
      return level <= depths.face || (j == 0 && level <= depths.sides[2]) ||
             (i == 0 && level <= depths.sides[1]) || (i + j == size_ && level <= depths.sides[0]);
    };
    const int beyond = levels_ - depths.grid();
    const auto copy = [&](std::int64_t i, std::int64_t j) {
      std::ranges::copy(patch.at({i >> beyond, j >> beyond}), at(i, j).begin());
    };
    copy(0, 0), copy(size_, 0), copy(0, size_);
    for (int level = 1; level <= levels_; ++level) {
      const std::int64_t step = size_ >> level;
      for (std::int64_t j = 0; j <= size_; j += step)
        for (std::int64_t i = 0; i + j <= size_; i += step) {
          const bool odd_i = (i / step) % 2 != 0, odd_j = (j / step) % 2 != 0;
          if (!odd_i && !odd_j) continue;
          if (has(level, i, j)) {
            copy(i, j);
            continue;
          }
          const std::int64_t x = odd_i ? step : 0, y = odd_j ? (odd_i ? -step : step) : 0;
          put_mean(at(i - x, j - y), at(i + x, j + y), at(i, j));
        }
    }
  }

 private:
  std::span<std::byte> at(std::int64_t i, std::int64_t j) {
    const std::size_t bytes = schema_.record_bytes();
    return std::span(records_).subspan(static_cast<std::size_t>(patch_vertex(size_, i, j)) * bytes,
                                       bytes);
  }
  void put_mean(std::span<const std::byte> a, std::span<const std::byte> b,
                std::span<std::byte> to) const {
    with_number_type(schema_.type, [&]<class Number>(Number) {
      for (std::size_t at = 0; at < to.size(); at += sizeof(Number))
        put(mean(get<Number>(a, at), get<Number>(b, at)), to, at);
      if constexpr (std::is_floating_point_v<Number>)
        if (is_normal_) make_unit<Number>(to);
    });
  }

  const AttributeSchema& schema_;
  bool is_normal_;
  int levels_;
  std::int64_t size_;
  std::vector<std::byte> records_;
};

void fill_attribute(const Store& from, const AttributeInfo& attribute, Store& to,
                    const std::function<void()>& patch_done) {
  const int levels = attribute.finest_level - from.base_level();
  const PatchSelection patches(from.base(), levels, all_faces(from.base()));
  DrawnPatch patch(from, attribute.schema.name);
  PatchWriter writer(to, {.attributes = {attribute.schema.name}});
  Grid grid(attribute.schema, levels);
  for (const FaceId face : patches.faces()) {
    patch.read(face, patches.drawn(face));
    grid.fill(patch);
    writer.write_patch_of_bytes(attribute.schema.name, face, attribute.finest_level,
                                grid.records());
    patch_done();
  }
  writer.finish();
}

}  // namespace

void fill_levels(const Store& from, Store& to, const ProgressCallback& progress) try {
  Provenance provenance = from.provenance();
  provenance.scheme.clear();
  StoreAccess::set_provenance(to, provenance);
  copy_notes(from, to);
  const std::uint64_t patches = from.base().face_count() * from.attributes().size();
  std::uint64_t done = 0;
  const auto patch_done = [&] {
    if (progress && !progress({"fill", ++done, patches}))
      throw Error(ErrorCode::kCancelled, "fill levels: cancelled");
  };
  for (const AttributeInfo& attribute : from.attributes())
    to.add_attribute(attribute.schema, attribute.finest_level);
  for (const AttributeInfo& attribute : from.attributes())
    fill_attribute(from, attribute, to, patch_done);
} catch (const std::bad_alloc&) {
  throw out_of_memory("fill levels");
}

PLAIT_END_NAMESPACE
