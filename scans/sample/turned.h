// sample/turned.h: small triangles that are turned over against the scan.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "sample/samples.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Whether the small triangle of three points of the scan is turned over: its normal points away
/// from the sum of the normals of the scan's faces at its corners, and it does not lie on one face
/// of the scan. If the scan has creases: of the faces that a corner on an
/// edge of the scan belongs to, the one counts whose normal is nearest.
bool is_turned(const Surface& scan, const SurfacePoint& a, const SurfacePoint& b,
               const SurfacePoint& c, bool has_creases = false);

/// Calls work(face, a, b, c) for each turned small triangle: its face of the base mesh, and the
/// numbers of its samples, which are those of sample_scan().
template <class Work>
void for_each_turned(const Surface& scan, const BaseMesh& base, int level,
                     std::span<const SurfacePoint> samples, bool has_creases, Work&& work) {
  const SampleNumbers numbers(base, level);
  for (FaceId face = 0; face < base.face_count(); ++face)
    numbers.for_each_triangle(face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
      if (is_turned(scan, samples[a], samples[b], samples[c], has_creases)) work(face, a, b, c);
    });
}

std::uint64_t count_turned(const Surface& scan, const BaseMesh& base, int level,
                           std::span<const SurfacePoint> samples);

/// Multiplies the weights of those vertices of the scan that are near samples of base faces with a
/// turned small triangle. `weights` has one number for each vertex of the scan. Pinned by
/// tests/scans/turned_test.cpp.
void weigh_turned_faces(const Surface& scan, const BaseMesh& base, int level,
                        std::span<const SurfacePoint> samples, bool has_creases, float factor,
                        std::vector<float>& weights);

PLAIT_END_NAMESPACE
