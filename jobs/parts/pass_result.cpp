#include "parts/pass_result.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "base/default_arithmetic.h"
#include "passes/fractal.h"
#include "passes/surface_passes.h"
#include "plait/error.h"
#include "plait/extend/provenance.h"
#include "plait/extend/store_access.h"
#include "plait/progress.h"
#include "store/attribute_levels.h"
#include "store/base_positions.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::string_view kPosition = "position", kSmooth = "smooth", kNoise = "noise",
                           kFractal = "fractal", kNormals = "normals";

[[noreturn]] void refuse_pass(const Pass& pass, const std::string& reason) {
  throw Error(ErrorCode::kInvalidArgument, fmt::format("pass '{}': {}", pass.name, reason));
}

bool is_built_in(const Pass& pass) {
  return pass.name == kSmooth || pass.name == kNoise || pass.name == kFractal ||
         pass.name == kNormals;
}

void check_share(const Pass& pass, std::string_view what, double share) {
  if (!(share >= 0 && share <= 1))
    refuse_pass(pass, fmt::format("{} {:g}, expected 0 to 1", what, share));
}

/// The provenance of positions that no scheme has made.
Provenance without_scheme(Provenance provenance, const std::string& program) {
  provenance.scheme.clear();
  provenance.limit = false;
  provenance.program = program;
  return provenance;
}

}  // namespace

void check_pass(const Pass& pass) {
  if (pass.remakes_normals && (!is_built_in(pass) || pass.name == kNormals))
    refuse_pass(pass, "expected smooth, noise or fractal, which remake normals of new positions");
  if (is_built_in(pass)) {
    if (pass.kernel) refuse_pass(pass, "a pass of the library has this name");
    check_share(pass, "factor", pass.factor);
    check_share(pass, "amplitude", pass.amplitude);
    if (pass.diagonal && !(*pass.diagonal > 0 && std::isfinite(*pass.diagonal)))
      refuse_pass(pass, fmt::format("diagonal {:g}, expected a length", *pass.diagonal));
    return;
  }
  if (!is_attribute_name(pass.name))
    refuse_pass(pass, "expected a name of 1 to 255 characters of [A-Za-z0-9_-]");
  if (!is_attribute_name(pass.result.name) || component_bytes(pass.result.type) == 0 ||
      pass.result.components < 1 || pass.result.components > 255)
    refuse_pass(
        pass, fmt::format("expected smooth, noise, fractal or normals, or a pass of the program's "
                          "own with the attribute that it makes, found '{}' x {}",
                          pass.result.name, pass.result.components));
}

PassResult result_of(const Pass& pass, const std::vector<AttributeSchema>& schemas,
                     const std::vector<int>& finest) {
  const auto find = [&](std::string_view name) {
    return static_cast<std::size_t>(std::ranges::find(schemas, name, &AttributeSchema::name) -
                                    schemas.begin());
  };
  PassResult result;
  const std::size_t position = find(kPosition);
  if (is_built_in(pass)) {
    if (position == schemas.size())
      throw Error(ErrorCode::kNotFound,
                  fmt::format("pass '{}': the store has no attribute 'position'", pass.name));
    const AttributeSchema& at = schemas[position];
    check_points(at, fmt::format("pass '{}'", pass.name));
    result.schema =
        pass.name == kNormals ? AttributeSchema{"normal", ComponentType::kFloat32, 3} : at;
  } else {
    result.schema = pass.result;
  }
  const std::size_t same = find(result.schema.name);
  result.replaces = same < schemas.size();
  if (result.replaces && schemas[same] != result.schema)
    refuse_pass(pass, fmt::format("it makes '{}' with {} x {}, and the store has {} x {}",
                                  result.schema.name, to_string(result.schema.type),
                                  result.schema.components, to_string(schemas[same].type),
                                  schemas[same].components));
  result.encoded_like = same;
  if (is_built_in(pass))
    result.like = position;
  else if (result.replaces)
    result.like = same;
  else if (schemas.empty())
    refuse_pass(pass, "the store has no attributes");
  else
    result.like = static_cast<std::size_t>(std::ranges::max_element(finest) - finest.begin());
  if (!result.replaces) result.encoded_like = result.like;
  return result;
}

VersionDescription version_after(const VersionDescription& at, const Pass& pass,
                                 std::uint64_t version, const std::string& program) {
  std::vector<AttributeSchema> schemas;
  std::vector<int> finest;
  for (const AttributeRecord& attribute : at.attributes) {
    schemas.push_back(attribute.schema);
    finest.push_back(at.finest_level(attribute));
  }
  const PassResult result = result_of(pass, schemas, finest);
  VersionDescription after = at;
  after.shards.clear();
  AttributeRecord made;
  made.schema = result.schema;
  made.number = after.next_attribute_number++;
  made.pipeline = at.attributes[result.encoded_like].pipeline;
  for (int level = at.provenance.base_level + 1; level <= finest[result.like]; ++level)
    made.levels.push_back({made.pipeline.of(level), Representation::kValues, version});
  if (!result.replaces) {
    after.attributes.push_back(std::move(made));
    return after;
  }
  for (AttributeRecord& attribute : after.attributes)
    if (attribute.schema.name == result.schema.name) attribute = made;
  if (result.schema.name == kPosition) after.provenance = without_scheme(after.provenance, program);
  return after;
}

namespace {

/// Adds the attribute that the pass fills, without its name. The provenance is that of the result.
AttributeId add_result(Store& store, const PassResult& result) {
  LevelPipelines pipelines = named_pipelines(store, static_cast<AttributeId>(result.encoded_like));
  // What made the blocks of the attribute before does not make those of the result.
  pipelines.for_each([](Pipeline& one) { one = one.with_recipe({}); });
  const int finest = store.attributes()[result.like].finest_level;
  const AttributeId added = StoreAccess::add_replacement(store, result.schema);
  store.set_pipeline(added, pipelines);
  StoreAccess::plan_levels(store, added, finest, true);
  while (store.attributes()[added].finest_level < finest) store.add_level(added);
  return added;
}

/// The visits of a pass, each with its name as the phase of the progress.
class PassVisits {
 public:
  PassVisits(const Pass& pass, const VisitOptions& options, int level) : options_(options) {
    options_.threads = thread_count(options.threads, pass.name);
    options_.level = level;
  }
  /// `name` must be valid during the visit.
  VisitOptions visit(std::string_view name) const {
    VisitOptions visit = options_;
    visit.name = name;
    if (options_.progress)
      visit.progress = [name, &progress = options_.progress](const Progress& now) {
        return progress({name, now.done, now.total});
      };
    return visit;
  }

 private:
  VisitOptions options_;
};

PassResult result_in(const Store& store, const Pass& pass) {
  std::vector<AttributeSchema> schemas;
  std::vector<int> finest;
  for (const AttributeInfo& info : store.attributes()) {
    schemas.push_back(info.schema);
    finest.push_back(info.finest_level);
  }
  return result_of(pass, schemas, finest);
}

/// What a pass measures before it changes the store.
struct Measured {
  PositionBox box;
  Waves waves;
};

Measured measure(Store& store, const Pass& pass, const PassVisits& visits, PassFigures& figures) {
  Measured measured;
  const bool is_fractal = pass.name == kFractal;
  if (!is_fractal && pass.name != kNoise) return measured;
  if (is_fractal || !pass.diagonal) {
    measured.box = box_of_positions(store, visits.visit("bounding box"));
    figures.diagonal = measured.box.diagonal();
  } else {
    figures.diagonal = *pass.diagonal;
  }
  if (!is_fractal) return measured;
  measured.waves = measure_waves(store, measured.box, visits.visit("mean edge"));
  figures.mean_edge = measured.waves.mean_edge;
  figures.wavelengths = measured.waves.lengths;
  return measured;
}

}  // namespace

AttributeId make_result(Store& store, const Pass& pass, const VisitOptions& options,
                        PassFigures& figures) {
  const DefaultArithmetic arithmetic;
  check_pass(pass);
  if (!is_built_in(pass) && !pass.kernel)
    refuse_pass(pass, "expected the kernel of the program's own pass, found none");
  const PassResult result = result_in(store, pass);
  std::optional<PassResult> of_normals;
  if (pass.remakes_normals) of_normals = result_in(store, {.name = std::string(kNormals)});
  const PassVisits visits(pass, options, store.attributes()[result.like].finest_level);
  const Measured measured = measure(store, pass, visits, figures);

  if (result.replaces && result.schema.name == kPosition)
    StoreAccess::set_provenance(store, without_scheme(store.provenance(), program_version()));
  const AttributeId made = add_result(store, result);
  const std::string into = store.attributes()[made].schema.name;
  const VisitOptions how = visits.visit(pass.name);
  Moves moves;
  if (pass.kernel)
    pass.kernel(store, into, how);
  else if (pass.name == kSmooth)
    moves = smooth_positions(store, into, pass.factor, how);
  else if (pass.name == kNoise)
    moves = add_noise(store, into, pass.amplitude * figures.diagonal, pass.seed, how);
  else if (pass.name == kFractal)
    moves = add_fractal(store, into, pass.amplitude * figures.diagonal, pass.seed, measured.box,
                        measured.waves, how);
  else
    make_normals(store, kPosition, into, how);
  figures.largest_move = moves.longest;
  figures.rounded_moves = moves.rounded;
  if (of_normals) {
    // The old normals go first: their blocks may be made from the positions that go then.
    const AttributeId normals = add_result(store, *of_normals);
    make_normals(store, into, store.attributes()[normals].schema.name, visits.visit(kNormals));
    StoreAccess::name_replacement(store, normals);
  }
  StoreAccess::name_replacement(store, store.attribute(into));
  return store.attribute(result.schema.name);
}

PassFigures run_pass(Store& store, const Pass& pass, const VisitOptions& options) try {
  PassFigures figures;
  make_result(store, pass, options, figures);
  return figures;
} catch (const std::bad_alloc&) {
  throw out_of_memory("pass " + pass.name);
}

PLAIT_END_NAMESPACE
