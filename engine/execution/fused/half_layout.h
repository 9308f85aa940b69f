// What one face has of the slots of one of its edges. Two faces have a half each of an interior
// edge's slots: of row r the own face has columns 0 to n - 1 - r, the other face the r ones behind.
//
// Halves are laid out as slots are, output after output and level after level, each from a line of
// the cache on, and have no meaning where the other face's records are. They are filled and put
// together in pieces: those of a group's halves stay in the innermost cache.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/edge_index.h"
#include "plait/fused.h"
#include "plait/store.h"

namespace plait {

constexpr std::size_t kLineBytes = 64;

/// Records are moved four at a time, which of three floats each fill whole vectors.
constexpr std::size_t kMoveRecords = 4;

/// From points of a lattice to records that follow one another, one of them at least of this half.
struct HalfMove {
  std::array<std::uint32_t, kMoveRecords> points;
  std::uint32_t offset;  ///< in the piece
};

/// A few levels, or some records of one.
struct HalfPiece {
  struct Part {
    int level;
    std::size_t at;       ///< in the piece
    std::size_t in_slot;  ///< in the slot of this level
    std::size_t bytes;
  };
  struct Moves {
    std::vector<HalfMove> own, other;
  };
  std::size_t at = 0;  ///< in an output of a half
  std::size_t bytes = 0;
  std::vector<Part> parts;
  std::array<Moves, 3> moves;           ///< [side]
  std::vector<std::uint32_t> own_mask;  ///< all bits set where the own face's records are
};

/// Where a half is: whole, or only the piece that is being made.
struct HalfBuffer {
  static constexpr std::size_t kWhole = ~std::size_t{0}, kPiece = 0;
  std::byte* memory;
  std::size_t extent;  ///< one of these

  bool whole() const { return extent == kWhole; }
  /// Where the piece begins that is `offset` bytes into the half.
  std::byte* piece(std::size_t offset) const { return memory + (offset & extent); }
};

/// An output of a half.
struct HalfOutput {
  std::uint32_t components = 3;
  std::size_t component_bytes = 4, record_bytes = 12;
  std::size_t offset = 0;  ///< in a half
};

class HalfLayout {
 public:
  /// Levels 1 to the finest, which is that of the lattice.
  HalfLayout(const Store& store, std::span<const AttributeId> attributes, int finest,
             const PatchLattice& lattice);

  static std::size_t half_bytes(const Store& store, std::span<const AttributeId> attributes,
                                int finest);
  /// At most, of what a layout itself keeps.
  static std::size_t table_bytes(const Store& store, std::span<const AttributeId> attributes,
                                 int finest);

  std::size_t bytes() const { return bytes_; }
  std::size_t most_piece_bytes() const { return most_piece_bytes_; }
  std::span<const HalfOutput> outputs() const { return outputs_; }
  std::span<const HalfPiece> pieces(std::size_t output) const {
    return pieces_[pieces_of_[output]];
  }

 private:
  std::vector<HalfOutput> outputs_;
  std::vector<std::vector<HalfPiece>> pieces_;
  std::vector<std::size_t> pieces_of_;  ///< [output]; records of one size share theirs
  std::size_t bytes_ = 0, most_piece_bytes_ = 0;
};

}  // namespace plait
