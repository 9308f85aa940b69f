// generate/generate.h: makes base meshes from a seed, for tests, demonstrations and measurements.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "plait/base_mesh.h"

PLAIT_BEGIN_NAMESPACE

enum class GeneratorKind : std::uint8_t {
  kMolecule,   ///< surface of a folded chain of atoms: closed, any genus, one component
  kTorus,      ///< closed, genus 1
  kIcosphere,  ///< closed, genus 0; 10 f^2 + 2 vertices are the geodesic sphere of frequency f
  kOpenSheet,  ///< a bumpy sheet with one border loop
};

std::string_view to_string(GeneratorKind kind) noexcept;
/// Errors: kInvalidArgument; the message lists the known kinds.
GeneratorKind generator_from_name(std::string_view name);

struct VertexCountRange {
  std::uint64_t fewest, most;
};
VertexCountRange vertex_count_range(GeneratorKind kind) noexcept;

/// Called with the finished fraction of the work, from 0 to 1; it never falls. May throw to stop
/// the work.
using GeneratorProgress = std::function<void(double)>;

/// Makes an oriented 2-manifold of one component with exactly `vertices` vertices, all of them
/// used. Valences are irregular: 3 and more, 2 and more on the border of an open sheet. Positions
/// are float32 values, so a PLY file holds them exactly. The same arguments give the same mesh on
/// every machine, because no step uses distributions or transcendental functions of the standard
/// library. Memory: under 1 KiB per vertex. Errors: kInvalidArgument for a count out of range.
/// Pinned by tests/jobs/generate/generate_test.cpp.
IndexedMesh generate(GeneratorKind kind, std::uint64_t vertices, std::uint64_t seed,
                     const GeneratorProgress& progress = {});

PLAIT_END_NAMESPACE
