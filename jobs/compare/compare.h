// compare/compare.h: the job that measures how far two surfaces are from each other.
#pragma once

#include <cstdint>
#include <filesystem>

#include "distance/distances.h"
#include "plait/detail/namespace.h"
#include "plait/extend/backend_registry.h"
#include "plait/job.h"

PLAIT_BEGIN_NAMESPACE

struct ComparisonRequest {
  std::filesystem::path first, second;  ///< mesh files or stores
  int level = -1;                       ///< of stores; -1: the finest
  std::uint64_t samples = 1000000;      ///< points on each surface
  int threads = 1;
};

struct SurfaceComparison {
  double diagonal = 0, mean_edge = 0;  ///< of the first surface
  Distances there, back;               ///< from the first to the second, and from it to the first
};

/// Progress counts samples. Both surfaces have to fit in memory. The same figures for each number
/// of threads. Errors: those of reading a mesh and of Store::open(); kInvalidArgument for a level
/// that is not there, and for a surface without faces or area; kOutOfMemory, kCancelled. Pinned by
/// tests/tools/scan_commands_test.cpp.
SurfaceComparison compare_surfaces(const ComparisonRequest& request,
                                   const BackendRegistry& backends, const JobWatch& watch = {});

PLAIT_END_NAMESPACE
