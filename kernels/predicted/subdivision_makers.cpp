// Recipes, and the makers that they name.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string>
#include <utility>

#include "plait/error.h"
#include "plait/extend/block_makers.h"
#include "plait/extend/pipeline_registry.h"
#include "predicted/normals_maker.h"
#include "predicted/surface_maker.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Normals of the positions of another attribute.
constexpr std::string_view kNormalsRule = "normals";

constexpr std::array<std::string_view, 3> kOutputs = {"position", "limit", "normal"};

struct Recipe {
  std::string_view scheme;
  MadeOutput output = MadeOutput::kPosition;
  ComponentType precision = ComponentType::kFloat32;
  int levels = 1;
};

Recipe read_recipe(std::string_view text) {
  std::array<std::string_view, 4> parts;
  std::size_t count = 0;
  for (std::string_view rest = text;; ++count) {
    const std::size_t slash = rest.find('/');
    if (count < parts.size()) parts[count] = rest.substr(0, slash);
    if (slash == std::string_view::npos) break;
    rest.remove_prefix(slash + 1);
  }
  Recipe recipe{parts[0]};
  const auto output = std::ranges::find(kOutputs, parts[1]);
  const bool is_double = parts[2] == to_string(ComponentType::kFloat64);
  const char* const end = parts[3].data() + parts[3].size();
  const auto [rest, error] = std::from_chars(parts[3].data(), end, recipe.levels);
  if (count + 1 != parts.size() || recipe.scheme.empty() || output == kOutputs.end() ||
      (!is_double && parts[2] != to_string(ComponentType::kFloat32)) || error != std::errc() ||
      rest != end || recipe.levels < 1 || recipe.levels > kMaxLevel)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("predict blocks: expected a recipe SCHEME/OUTPUT/PRECISION/LEVELS, "
                            "found \"{}\"",
                            text.substr(0, 100)));
  recipe.output = static_cast<MadeOutput>(output - kOutputs.begin());
  if (is_double) recipe.precision = ComponentType::kFloat64;
  return recipe;
}

/// Of the vertex with the most faces.
std::uint32_t most_faces(const Topology& mesh) {
  std::vector<std::uint32_t> faces(mesh.vertex_corners.size());
  for (const auto& corners : mesh.faces)
    for (const VertexId vertex : corners) ++faces[vertex];
  return faces.empty() ? 0 : *std::ranges::max_element(faces);
}

class SubdivisionMakers final : public BlockMakers {
 public:
  explicit SubdivisionMakers(std::vector<OneRingScheme> own) : schemes_(std::move(own)) {
    schemes_.push_back(loop_scheme());
    schemes_.push_back(midpoint_scheme());
  }

  std::string recipe(const PlannedLevels& planned) const override {
    const auto& [schema, provenance, finest_level, others_are_complete] = planned;
    const int levels = relative_to_base(finest_level, provenance.base_level).refinements;
    if (levels < 1 || schema.components != 3) return {};
    const OneRingScheme* const scheme = find(provenance.scheme);
    const bool is_normal = schema.name == "normal" && schema.type == ComponentType::kFloat32;
    if (scheme == nullptr)
      return is_normal && others_are_complete && levels <= kMostMadeLevels
                 ? fmt::format("{}/position/{}", kNormalsRule, levels)
                 : std::string();
    if (!is_normal && (schema.name != "position" || schema.type != provenance.precision)) return {};
    const std::size_t output = is_normal ? 2 : provenance.limit ? 1 : 0;
    return fmt::format("{}/{}/{}/{}", scheme->name(), kOutputs[output],
                       to_string(provenance.precision), levels);
  }

  std::unique_ptr<BlockMaker> open(const MadeLevel& level) const override {
    if (const auto source = source_in(level.recipe)) {
      if (source->rule == kNormalsRule) return make_normals_maker(*source, level);
      throw Error(ErrorCode::kNotSupported,
                  fmt::format("predict blocks: rule '{}' is none that this program knows",
                              source->rule.substr(0, 100)));
    }
    const Recipe recipe = read_recipe(level.recipe);
    const OneRingScheme* const scheme = find(recipe.scheme);
    if (scheme == nullptr)
      throw Error(ErrorCode::kNotSupported,
                  fmt::format("predict blocks: scheme '{}' is none that this program can repeat",
                              recipe.scheme));
    return recipe.precision == ComponentType::kFloat64 ? make<double>(*scheme, recipe, level)
                                                       : make<float>(*scheme, recipe, level);
  }

 private:
  const OneRingScheme* find(std::string_view name) const {
    const auto found = std::ranges::find(schemes_, name, &OneRingScheme::name);
    return found == schemes_.end() ? nullptr : &*found;
  }

  template <class Real>
  static std::unique_ptr<BlockMaker> make(const OneRingScheme& scheme, const Recipe& recipe,
                                          const MadeLevel& level) {
    const OneRing<Real>& rule = scheme.rule<Real>();
    const ComponentType type = recipe.output == MadeOutput::kNormal
                                   ? ComponentType::kFloat32
                                   : RecordTraits<Vector3<Real>>::kType;
    const int own_level = level.geometry.level().refinements;
    if (level.schema.type != type || level.schema.components != 3 || own_level > recipe.levels ||
        own_level > kMostMadeLevels || (recipe.output == MadeOutput::kLimit && !rule.has_limits()))
      return nullptr;
    // With fewer faces, a vertex is no hub: the fused executor computes it for each run of faces
    // too.
    const std::uint32_t faces = most_faces(level.surroundings.mesh);
    if (faces >= static_cast<std::uint32_t>(BaseRings<OneRing<Real>>::kHubValence)) return nullptr;
    return std::make_unique<SurfaceMaker<Real>>(rule, level, recipe.output, recipe.levels, faces);
  }

  std::vector<OneRingScheme> schemes_;
};

}  // namespace

std::shared_ptr<const BlockMakers> subdivision_block_makers(
    std::vector<OneRingScheme> own_schemes) {
  return std::make_shared<const SubdivisionMakers>(std::move(own_schemes));
}

std::shared_ptr<const BlockMakers> library_block_makers() {
  static const std::shared_ptr<const BlockMakers> makers = subdivision_block_makers();
  return makers;
}

PLAIT_END_NAMESPACE
