// Makes the blocks of one level of a surface: positions, limit positions or normals.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "fused/surface_refiner.h"
#include "plait/detail/one_ring.h"
#include "plait/extend/block_maker.h"
#include "predicted/ring_walk.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

enum class MadeOutput : std::uint8_t { kPosition, kLimit, kNormal };

template <class Real>
class SurfaceMaker final : public BlockMaker {
 public:
  /// `level` without its recipe. `levels`: how often the base mesh was refined in all. REQUIRES:
  /// the level's records are those of the output, and no vertex has more than `most_faces` faces.
  SurfaceMaker(const OneRing<Real>& rule, const MadeLevel& level, MadeOutput output, int levels,
               std::uint32_t most_faces);
  ~SurfaceMaker() override;
  SurfaceMaker(const SurfaceMaker&) = delete;
  SurfaceMaker& operator=(const SurfaceMaker&) = delete;

  std::uint64_t scratch_bytes() const noexcept override;
  void make(std::uint64_t block, SourceBytes sources, std::span<std::byte> raw) const override;
  bool make_base(std::span<std::byte> records) const override;
  bool makes(std::uint64_t block, SourceBytes sources,
             std::span<const std::byte> raw) const override;

 private:
  struct Workspace;
  class Lease;
  struct Side;
  using Sides = std::array<Side, 3>;
  template <class Byte, class Visit>
  bool visit_block(std::uint64_t block, std::span<Byte> raw, Visit visit) const;
  template <class Byte, class Visit>
  bool visit_group(Workspace& work, std::span<const FaceId> group, std::uint64_t block,
                   std::span<Byte> raw, Visit& visit) const;
  void find_faces(std::uint64_t block, std::vector<FaceId>& faces) const;

  /// A group of faces that is refined in one run. Its base vertices are evaluated once.
  static constexpr std::size_t kRunFaces = 256;

  OneRing<Real> rule_;
  const LevelGeometry& geometry_;
  Topology mesh_;
  std::span<const Vector3<double>> positions_;  ///< of the base mesh
  MadeOutput output_;
  int level_, levels_;
  std::uint32_t most_faces_;
  SurfaceRefinement<OneRing<Real>> refinement_;
  mutable std::mutex mutex_;
  mutable std::unique_ptr<Workspace> idle_;  ///< of the last call
};

PLAIT_END_NAMESPACE
