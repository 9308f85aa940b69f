#include "render/scalar.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <span>

#include "base/number_type.h"
#include "export/vertex_stream.h"
#include "plait/error.h"
#include "plait/extend/patch.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

template <class Number>
class TypedPatches final : public ScalarPatches {
 public:
  TypedPatches(Store& store, AttributeId attribute, int level, std::uint64_t share_bytes)
      : level_(level), patches_(store, attribute, share_bytes) {
    patches_.activate(level, 1, 0);
  }
  void enter(FaceId face) override { current_.emplace(patches_.patch(face)); }
  double at(std::int64_t i, std::int64_t j) const override {
    return static_cast<double>(current_->at(level_, i, j));
  }

 private:
  int level_;
  StorePatches<Number> patches_;
  std::optional<typename StorePatches<Number>::Patch> current_;
};

}  // namespace

ScalarRange scalar_range(Store& store, const std::string& attribute, int level) {
  const AttributeId id = store.attribute(attribute);
  const AttributeSchema schema = store.attributes()[id].schema;
  const int finest = store.attributes()[id].finest_level;
  if (schema.components != 1)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("render {}: attribute '{}': expected one number for each vertex, found "
                    "{} x {}",
                    store.path().native(), attribute, to_string(schema.type), schema.components));
  if (finest < level)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("render {}: attribute '{}' ends at level {}, expected level {} or more",
                            store.path().native(), attribute, finest, level));
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  ScalarRange range{kInfinity, -kInfinity};
  stream_vertices(store, std::span(&id, 1), level, [&](auto records, std::size_t count) {
    with_number_type(schema.type, [&]<class Number>(Number number) {
      for (std::size_t vertex = 0; vertex < count; ++vertex) {
        std::memcpy(&number, records[0].data() + vertex * sizeof number, sizeof number);
        const auto wide = static_cast<double>(number);
        if (!std::isfinite(wide)) continue;
        range.low = std::min(range.low, wide);
        range.high = std::max(range.high, wide);
      }
    });
  });
  return range.low <= range.high ? range : ScalarRange{};
}

std::unique_ptr<ScalarPatches> open_scalar(Store& store, const std::string& attribute, int level,
                                           std::uint64_t share_bytes) {
  const AttributeId id = store.attribute(attribute);
  return with_number_type(store.attributes()[id].schema.type,
                          [&]<class Number>(Number) -> std::unique_ptr<ScalarPatches> {
                            return std::make_unique<TypedPatches<Number>>(store, id, level,
                                                                          share_bytes);
                          });
}

PLAIT_END_NAMESPACE
