// bench/peers/compression_surfaces.h: the surfaces whose blocks the measurement of compression
// encodes, and the raw bytes of their levels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "plait/attribute.h"
#include "plait/extend/backend.h"
#include "plait/layout.h"
#include "plait/store.h"

namespace plait::bench {

struct SurfaceSettings {
  int level = 5;        ///< the finest, whose blocks are measured
  int blocks = 32;      ///< of each attribute, at most
  int block_kib = 256;  ///< KiB of a block
};

/// A store in memory with positions, and with normals unless they are not wanted. `name` is "exact"
/// for a Loop surface, or "noise", "fractal" or "noise, other normals" for one that is displaced.
/// Errors: as subdivide() and displace().
Store make_surface(const SurfaceSettings& settings, const LaidOutMesh& mesh,
                   const std::string& name, bool normals = true);

/// What filters must know of a surface, and the raw bytes of its levels. Refers to its store.
struct MeasuredSurface {
  LevelSurroundings surroundings;
  std::vector<std::vector<std::vector<std::byte>>> levels;  ///< [attribute][level - 1]

  explicit MeasuredSurface(const Store& store)
      : surroundings{store.base().topology(), 0, {}, store.base().positions()} {}

  std::span<const std::byte> bytes_of(const ContextBlock& block) const;
};

/// One attribute, and the blocks of its finest level that are measured. Refers to its surface.
struct MeasuredAttribute {
  const MeasuredSurface* surface;
  std::uint32_t number;
  AttributeSchema schema;
  int level;
  const LevelGeometry* finest;
  std::vector<std::uint64_t> blocks;

  std::span<const std::byte> bytes_of(std::uint64_t block) const {
    return surface->bytes_of({number, level, block});
  }
};

/// Reads all levels of an attribute of `store`, and adds them to `surface`. `store` and `surface`
/// outlive the result. Errors: kNotFound for the name.
MeasuredAttribute read_attribute(const SurfaceSettings& settings, Store& store,
                                 const std::string& name, MeasuredSurface& surface);

}  // namespace plait::bench
