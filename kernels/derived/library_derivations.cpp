// The rules of the library: "normals/SOURCE".
#include <fmt/format.h>

#include <string>
#include <utility>

#include "derived/normals_of_positions.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::string_view kNormalsRule = "normals";

[[noreturn]] void refuse_to_derive(std::string_view name, const std::string& what) {
  throw Error(ErrorCode::kNotSupported, fmt::format("derive '{}': {}", name.substr(0, 100), what));
}

class LibraryDerivations final : public Derivations {
 public:
  std::string usual(const AttributeSchema& schema) const override {
    std::string derivation = fmt::format("{}/position", kNormalsRule);
    source_of(derivation, schema);
    return derivation;
  }

  std::string source_of(std::string_view derivation, const AttributeSchema& schema) const override {
    const std::size_t slash = derivation.find('/');
    if (slash == std::string_view::npos || derivation.substr(0, slash) != kNormalsRule ||
        slash + 1 == derivation.size())
      refuse_to_derive(schema.name, fmt::format("expected the rule normals/SOURCE, found \"{}\"",
                                                derivation.substr(0, 100)));
    const std::string_view source = derivation.substr(slash + 1);
    if (schema.type != ComponentType::kFloat32 || schema.components != 3 || schema.name == source)
      refuse_to_derive(
          schema.name,
          fmt::format("rule {} makes 3 x float32 of another attribute, found {} x {} of '{}'",
                      kNormalsRule, schema.components, to_string(schema.type),
                      source.substr(0, 100)));
    return std::string(source);
  }

  std::unique_ptr<Deriver> open(std::string_view derivation, const AttributeSchema& schema,
                                DerivationSource source) const override {
    source_of(derivation, schema);
    if (source.schema.components != 3 || (source.schema.type != ComponentType::kFloat32 &&
                                          source.schema.type != ComponentType::kFloat64))
      refuse_to_derive(
          schema.name,
          fmt::format("rule {} reads 3 float32 or float64, found {} x {} in '{}'", kNormalsRule,
                      source.schema.components, to_string(source.schema.type), source.schema.name));
    return make_normals_of_positions(std::move(source));
  }
};

}  // namespace

std::shared_ptr<const Derivations> library_derivations() {
  static const std::shared_ptr<const Derivations> rules =
      std::make_shared<const LibraryDerivations>();
  return rules;
}

PLAIT_END_NAMESPACE
