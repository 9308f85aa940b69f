// remesh/read_scan.h: the scan of a remeshing, read and repaired.
#pragma once

#include <cstdint>

#include "remesh/remesh.h"
#include "remesh/scan_attributes.h"
#include "remesh/scan_face_attributes.h"
#include "remesh/scan_progress.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct ScanToSample {
  Surface surface;
  ScanAttributes attributes;
  ScanFaceAttributes of_faces;
};

/// Says what is left out, merged, lost and repaired, in warnings and in the report. Errors: those
/// of read_attributed_mesh(), repair() and check_memory_for(); kCancelled.
ScanToSample read_scan(const RemeshRequest& request, const ScanProgress& progress,
                       const JobWatch& watch, RemeshReport& report);

/// Throws kOutOfMemory if the machine has less than the request needs for a scan of
/// `scan_faces`.
void check_memory_for(const RemeshRequest& request, std::uint64_t scan_faces);

PLAIT_END_NAMESPACE
