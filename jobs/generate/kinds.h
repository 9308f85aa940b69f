// generate/kinds.h: one function for each kind of mesh; generate() checks the arguments.
#pragma once

#include <cstdint>

#include "generate/generate.h"
#include "generate/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {

IndexedMesh make_molecule(std::uint64_t vertices, std::uint64_t seed, const Progress& progress);
IndexedMesh make_torus(std::uint64_t vertices, std::uint64_t seed, const Progress& progress);
IndexedMesh make_icosphere(std::uint64_t vertices, std::uint64_t seed, const Progress& progress);
IndexedMesh make_open_sheet(std::uint64_t vertices, std::uint64_t seed, const Progress& progress);

}  // namespace generation
PLAIT_END_NAMESPACE
