#include "execution/fused/half_layout.h"

#include <algorithm>
#include <bit>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

std::size_t whole_lines(std::size_t bytes) {
  return (bytes + kLineBytes - 1) / kLineBytes * kLineBytes;
}

/// The pieces of all halves of a group together take about half of a first-level cache of 32 KiB,
/// unless records are very large. The result is a multiple of 16, because 16 records of any size
/// fill whole cache lines.
std::int64_t piece_records(std::size_t record_bytes) {
  constexpr std::size_t kPieceBytes = 768;
  return static_cast<std::int64_t>(
      std::clamp<std::size_t>(std::bit_floor(kPieceBytes / record_bytes), 16, 64));
}

/// The bytes of `records` records in whole cache lines. There is room for one whole move, although
/// level 1 has only one record.
std::size_t run_bytes(std::uint64_t records, std::size_t record_bytes) {
  return whole_lines(std::max<std::uint64_t>(records, kMoveRecords) * record_bytes);
}

std::size_t output_bytes(std::size_t record_bytes, int finest) {
  std::size_t bytes = 0;
  for (int level = 1; level <= finest; ++level)
    bytes += run_bytes(slot_records(level), record_bytes);
  return bytes;
}

class PieceMaker {
 public:
  PieceMaker(const PatchLattice& lattice, std::size_t record_bytes, int finest)
      : lattice_(lattice),
        record_bytes_(record_bytes),
        piece_records_(piece_records(record_bytes)),
        finest_(finest) {}

  std::vector<HalfPiece> make() {
    for (int level = 1; level <= finest_; ++level) {
      const auto records = static_cast<std::int64_t>(slot_records(level));
      if (level == 1 || records >= piece_records_) begin_piece();
      for (std::int64_t first = 0; first < records; first += piece_records_) {
        if (first > 0) begin_piece();
        add_part(level, first, std::min(records, first + piece_records_));
      }
    }
    return std::move(pieces_);
  }

 private:
  void begin_piece() {
    const std::size_t at = pieces_.empty() ? 0 : pieces_.back().at + pieces_.back().bytes;
    pieces_.emplace_back().at = at;
  }

  void add_part(int level, std::int64_t first, std::int64_t after) {
    HalfPiece& piece = pieces_.back();
    const auto records = static_cast<std::uint64_t>(after - first);
    const std::size_t at = piece.bytes;
    piece.parts.push_back(
        {level, at, static_cast<std::size_t>(first) * record_bytes_, records * record_bytes_});
    piece.bytes += run_bytes(records, record_bytes_);
    piece.own_mask.resize(piece.bytes / sizeof(std::uint32_t));
    for (std::uint64_t record = 0; record < records; record += kMoveRecords)
      add_move(piece, level, first + static_cast<std::int64_t>(record),
               at + record * record_bytes_);
  }

  void add_move(HalfPiece& piece, int level, std::int64_t first, std::size_t offset) const {
    const auto records = static_cast<std::int64_t>(slot_records(level)), n = slot_side(level);
    const auto is_own = [&](std::int64_t record) { return record / n + record % n < n; };
    bool any_own = false, any_other = false;
    for (std::size_t i = 0; i < kMoveRecords; ++i) {
      const std::int64_t record = first + static_cast<std::int64_t>(i);
      if (record >= records) continue;
      (is_own(record) ? any_own : any_other) = true;
      if (is_own(record))
        std::fill_n(&piece.own_mask[(offset + i * record_bytes_) / sizeof(std::uint32_t)],
                    record_bytes_ / sizeof(std::uint32_t), ~std::uint32_t{0});
    }
    for (int side = 0; side < 3; ++side) {
      HalfPiece::Moves& moves = piece.moves[static_cast<std::size_t>(side)];
      if (any_own) moves.own.push_back(move(side, level, first, offset, true));
      if (any_other) moves.other.push_back(move(side, level, first, offset, false));
    }
  }

  /// For a record that does not belong to the half, the move reads the point of one that does.
  HalfMove move(int side, int level, std::int64_t first, std::size_t offset, bool own) const {
    const auto records = static_cast<std::int64_t>(slot_records(level));
    const std::int64_t n = slot_side(level), scale = std::int64_t{1} << (finest_ - level);
    HalfMove result{{}, static_cast<std::uint32_t>(offset)};
    const auto for_each_of_half = [&](auto visit) {
      for (std::size_t i = 0; i < kMoveRecords; ++i) {
        const std::int64_t record = first + static_cast<std::int64_t>(i);
        if (record >= records || (record / n + record % n < n) != own) continue;
        const std::int64_t row = own ? record / n : n - 1 - record / n,
                           column = own ? record % n : n - 1 - record % n;
        const FaceIndex at = from_side(0, {side, level, row, column});
        visit(i, static_cast<std::uint32_t>(lattice_.index(at.i * scale, at.j * scale)));
      }
    };
    for_each_of_half([&](std::size_t, std::uint32_t point) { result.points.fill(point); });
    for_each_of_half([&](std::size_t i, std::uint32_t point) { result.points[i] = point; });
    return result;
  }

  const PatchLattice& lattice_;
  std::size_t record_bytes_;
  std::int64_t piece_records_;
  int finest_;
  std::vector<HalfPiece> pieces_;
};

}  // namespace

HalfLayout::HalfLayout(const Store& store, std::span<const AttributeId> attributes, int finest,
                       const PatchLattice& lattice) {
  for (const AttributeId id : attributes) {
    const AttributeSchema& schema = store.attributes()[id].schema;
    const std::size_t record_bytes = schema.record_bytes();
    std::size_t like = 0;
    while (like < outputs_.size() && outputs_[like].record_bytes != record_bytes) ++like;
    if (like < outputs_.size()) {
      pieces_of_.push_back(pieces_of_[like]);
    } else {
      pieces_of_.push_back(pieces_.size());
      pieces_.push_back(PieceMaker(lattice, record_bytes, finest).make());
    }
    outputs_.push_back({schema.components, component_bytes(schema.type), record_bytes, bytes_});
    bytes_ += output_bytes(record_bytes, finest);
  }
  for (const std::vector<HalfPiece>& pieces : pieces_)
    for (const HalfPiece& piece : pieces)
      most_piece_bytes_ = std::max(most_piece_bytes_, piece.bytes);
}

std::size_t HalfLayout::half_bytes(std::span<const std::size_t> record_bytes, int finest) {
  std::size_t bytes = 0;
  for (const std::size_t record : record_bytes) bytes += output_bytes(record, finest);
  return bytes;
}

std::size_t HalfLayout::table_bytes(std::span<const std::size_t> record_bytes, int finest) {
  std::size_t moves = 0;
  for (int level = 1; level <= finest;
       ++level)  // both halves have a move where a row changes from one half to the other
    moves += slot_records(level) / kMoveRecords + static_cast<std::size_t>(slot_side(level));
  return half_bytes(record_bytes, finest) + record_bytes.size() * 3 * moves * sizeof(HalfMove);
}

PLAIT_END_NAMESPACE
