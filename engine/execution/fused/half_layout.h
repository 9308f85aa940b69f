// The half of an edge's slots that belongs to one face. The slots of an inner edge have two
// halves. In row r, columns 0 to n - 1 - r belong to the own face, and the other r columns belong
// to the other face.
// A half has the same layout as the slots: output after output, level after level, each level
// aligned to a cache line. The bytes at the places of the other face's records are undefined. The
// executor fills and joins halves in pieces, which are so small that the pieces of a group stay in
// the first-level cache.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/extend/edge_index.h"
#include "plait/extend/fused.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

constexpr std::size_t kLineBytes = 64;

/// Records are moved four at a time, because four records of three floats fill whole vectors.
constexpr std::size_t kMoveRecords = 4;

/// Moves points of a lattice to consecutive records. At least one of these belongs to the half.
struct HalfMove {
  std::array<std::uint32_t, kMoveRecords> points;
  std::uint32_t offset;  ///< of the first record in the piece
};

/// A part of a half: a few whole levels, or some records of one level.
struct HalfPiece {
  struct PartOfSlot {
    int level;
    std::size_t at;       ///< in the piece
    std::size_t in_slot;  ///< in the slot of this level
    std::size_t bytes;
  };
  struct Moves {
    std::vector<HalfMove> own, other;
  };
  std::size_t at = 0;  ///< offset in the bytes of one output of a half
  std::size_t bytes = 0;
  std::vector<PartOfSlot> parts;
  std::array<Moves, 3> moves;           ///< [side]
  std::vector<std::uint32_t> own_mask;  ///< all bits set where the own face's records are
};

/// Memory for a whole half, or only for the piece that the executor works on. One word, which
/// processors choose without a branch.
class HalfBuffer {
 public:
  enum Extent : std::uintptr_t { kPiece = 0, kWhole = 1 };

  HalfBuffer() = default;
  /// `memory` is aligned to cache lines, or nullptr.
  HalfBuffer(std::byte* memory, Extent extent)
      : word_(reinterpret_cast<std::uintptr_t>(memory) | extent) {}

  std::byte* memory() const {
    return reinterpret_cast<std::byte*>(word_ & ~std::uintptr_t{kWhole});
  }
  bool whole() const { return (word_ & kWhole) != 0; }
  /// The address of the piece at `offset` bytes in the half.
  std::byte* piece(std::size_t offset) const { return memory() + (whole() ? offset : 0); }

 private:
  std::uintptr_t word_ = 0;
};

/// One output (attribute) in a half.
struct HalfOutput {
  std::uint32_t components = 3;
  std::size_t component_bytes = 4, record_bytes = 12;
  std::size_t offset = 0;  ///< in the half
};

class HalfLayout {
 public:
  /// Lays out levels 1 to `finest`, which is the level of the lattice.
  HalfLayout(const Store& store, std::span<const AttributeId> attributes, int finest,
             const PatchLattice& lattice);

  static std::size_t half_bytes(std::span<const std::size_t> record_bytes, int finest);
  /// An upper limit for the bytes of a layout object's tables.
  static std::size_t table_bytes(std::span<const std::size_t> record_bytes, int finest);

  std::size_t bytes() const { return bytes_; }
  std::size_t most_piece_bytes() const { return most_piece_bytes_; }
  std::span<const HalfOutput> outputs() const { return outputs_; }
  std::span<const HalfPiece> pieces(std::size_t output) const {
    return pieces_[pieces_of_[output]];
  }

 private:
  std::vector<HalfOutput> outputs_;
  std::vector<std::vector<HalfPiece>> pieces_;
  std::vector<std::size_t>
      pieces_of_;  ///< [output]; outputs with records of one size share their pieces
  std::size_t bytes_ = 0, most_piece_bytes_ = 0;
};

PLAIT_END_NAMESPACE
