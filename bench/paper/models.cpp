#include "paper/models.h"

#include <fmt/format.h>

#include <array>
#include <random>
#include <string>
#include <utility>

#include "base/text.h"
#include "generate/generate.h"
#include "generate/reduce.h"
#include "plait/subdivide.h"

namespace plait::paper {
namespace {

constexpr double minutes(int whole, int seconds) { return 60.0 * whole + seconds; }
constexpr std::uint64_t kMegabyte = 1'000'000;
constexpr std::uint64_t kGigabyte = 1'000'000'000;
constexpr std::uint64_t kSmallSeed = 1;
constexpr double kRandomness = 1;  // irregular valences, as scans have them

IndexedMesh arrays_of(const BaseMesh& mesh) {
  return {{mesh.positions().begin(), mesh.positions().end()},
          {mesh.faces().begin(), mesh.faces().end()}};
}

/// Faces in random order, as those of a scan: generated ones are in an order that no layout
/// betters, and would show nothing of what ordering does.
IndexedMesh shuffled(IndexedMesh mesh) {
  std::mt19937_64 random(kSmallSeed);
  for (std::size_t left = mesh.faces.size(); left > 1; --left)
    std::swap(mesh.faces[left - 1], mesh.faces[random() % left]);
  return mesh;
}

/// A small one has `vertices`, unless that is 0.
StandIn stand_in_of(const Model& model, std::uint64_t vertices) {
  return vertices == 0 ? model.stand_in : StandIn{vertices, kSmallSeed, 0};
}

}  // namespace

std::span<const Model> models() {
  static const std::array<Model, 3> kModels = {{
      {.name = "deo",
       .title = "Deo",
       .vertices = 26'016,
       .edges = 78'084,
       .levels = 5,
       .face_span = 4'864,
       .loop_span = 4'983,
       .elapsed = {minutes(8, 27), minutes(5, 26)},
       .memory_bytes = {180 * kMegabyte, 640 * kMegabyte},
       .processor_seconds = minutes(2, 0),
       .disk_bytes = 1 * kGigabyte,
       .stand_in = {26'016, 5, 0}},
      {.name = "david",
       .title = "David",
       .vertices = 274'831,
       .edges = 824'517,
       .levels = 5,
       .face_span = 17'764,
       .loop_span = 24'857,
       .elapsed = {minutes(115, 24)},
       .memory_bytes = {913 * kMegabyte},
       .processor_seconds = minutes(21, 20),
       .disk_bytes = 10 * kGigabyte,
       .stand_in = {26'016, 21, 2}},
      {.name = "buddha",
       .title = "happy Buddha",
       .vertices = 545'714,
       .edges = 1'637'334,
       .levels = 4,
       .face_span = 38'765,
       .loop_span = 56'176,
       .elapsed = {minutes(71, 41)},
       .memory_bytes = {530 * kMegabyte},
       .processor_seconds = minutes(11, 39),
       .disk_bytes = 5 * kGigabyte,
       .stand_in = {90'000, 25, 2}},
  }};
  return kModels;
}

const Model& model_from_name(std::string_view name) {
  std::vector<std::string_view> names;
  for (const Model& model : models()) {
    if (model.name == name) return model;
    names.push_back(model.name);
  }
  throw unknown_name("model", name, names);
}

IndexedMesh make_stand_in(const Model& model, std::uint64_t vertices) {
  const StandIn how = stand_in_of(model, vertices);
  IndexedMesh mesh = generate(GeneratorKind::kMolecule, how.molecule_vertices, how.seed);
  if (how.refinements == 0) return shuffled(std::move(mesh));
  mesh = arrays_of(rebase(BaseMesh::build(std::move(mesh)), how.refinements, Scheme::kLoop));
  const GeneratorProgress nobody = [](double) {};
  return shuffled(generation::reduce(
      std::move(mesh), {.vertices = model.vertices, .seed = how.seed, .randomness = kRandomness},
      generation::Progress(nobody)));
}

std::string describe_stand_in(const Model& model, std::uint64_t vertices) {
  const StandIn how = stand_in_of(model, vertices);
  return fmt::format(
      "stand-in: a generated molecule of {} vertices, seed {}, {}faces in random order",
      how.molecule_vertices, how.seed,
      how.refinements == 0 ? std::string()
                           : fmt::format("refined {} times and reduced to {} vertices, ",
                                         how.refinements, model.vertices));
}

}  // namespace plait::paper
