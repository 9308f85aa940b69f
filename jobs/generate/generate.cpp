#include "generate/generate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "base/text.h"
#include "generate/kinds.h"
#include "generate/progress.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr NameTable<GeneratorKind, 4> kGenerators("kind of mesh",
                                                  {{GeneratorKind::kMolecule, "molecule"},
                                                   {GeneratorKind::kTorus, "torus"},
                                                   {GeneratorKind::kIcosphere, "icosphere"},
                                                   {GeneratorKind::kOpenSheet, "open-sheet"}});

IndexedMesh make(GeneratorKind kind, std::uint64_t vertices, std::uint64_t seed,
                 const generation::Progress& progress) {
  switch (kind) {
    case GeneratorKind::kMolecule:
      return generation::make_molecule(vertices, seed, progress);
    case GeneratorKind::kTorus:
      return generation::make_torus(vertices, seed, progress);
    case GeneratorKind::kIcosphere:
      return generation::make_icosphere(vertices, seed, progress);
    case GeneratorKind::kOpenSheet:
      return generation::make_open_sheet(vertices, seed, progress);
  }
  return {};
}

}  // namespace

std::string_view to_string(GeneratorKind kind) noexcept { return kGenerators.name_of(kind); }

GeneratorKind generator_from_name(std::string_view name) { return kGenerators.find(name); }

VertexCountRange vertex_count_range(GeneratorKind kind) noexcept {
  // Side numbers have 32 bits, also while the surface has more vertices than the result.
  constexpr std::uint64_t kMost = 200'000'000;
  switch (kind) {
    case GeneratorKind::kMolecule:
      return {12, kMost};
    case GeneratorKind::kTorus:
      return {12, kMost};
    case GeneratorKind::kIcosphere:
      return {12, kMost};
    case GeneratorKind::kOpenSheet:
      return {4, kMost};
  }
  return {0, 0};
}

IndexedMesh generate(GeneratorKind kind, std::uint64_t vertices, std::uint64_t seed,
                     const GeneratorProgress& progress) {
  const auto [fewest, most] = vertex_count_range(kind);
  if (vertices < fewest || vertices > most)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("generate {}: expected {} to {} vertices, found {}", to_string(kind),
                            fewest, most, vertices));
  // Some steps are repeated. The reported fraction must not fall then, but a call that is cancelled
  // ends in a repeated step too.
  double reached = 0;
  const GeneratorProgress report = [&](double fraction) {
    if (!progress) return;
    reached = std::max(reached, fraction);
    progress(reached);
  };
  report(0);
  IndexedMesh mesh = make(kind, vertices, seed, generation::Progress(report));
  if (mesh.positions.size() != vertices)
    throw Error(ErrorCode::kBadState,
                fmt::format("generate {}: expected {} vertices for seed {}, found a surface that "
                            "cannot be reduced below {}",
                            to_string(kind), vertices, seed, mesh.positions.size()));
  for (Vector3<double>& position : mesh.positions)
    for (int axis = 0; axis < 3; ++axis) position[axis] = static_cast<float>(position[axis]);
  report(1);
  return mesh;
}

PLAIT_END_NAMESPACE
