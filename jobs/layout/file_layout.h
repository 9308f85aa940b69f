// layout/file_layout.h: the passes of lay_out_in_files(), and the records that they sort.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "format/packed_mesh.h"
#include "layout/external_sort.h"
#include "layout/hilbert_cells.h"
#include "layout/index_writer.h"
#include "layout/lay_out_in_files.h"
#include "layout/packed_writer.h"
#include "layout/ranked_bits.h"
#include "layout/temporary_file.h"
#include "layout/vertex_fan.h"
#include "mesh/connectivity.h"
#include "mesh/files/mesh_stream.h"
#include "plait/error.h"
#include "plait/extend/directory.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A corner of a face, with what its vertex knows.
struct CornerOfFace {
  std::uint32_t code;  ///< FaceSide
  VertexId vertex;
  std::uint32_t twin;      ///< of the side to the next corner
  std::uint32_t is_first;  ///< in the fan of its vertex
  std::array<double, 3> position;
  friend bool operator<(const CornerOfFace& a, const CornerOfFace& b) { return a.code < b.code; }
};

/// A face with what the order of the faces needs.
struct KeyedFace {
  std::uint64_t key;  ///< on the Hilbert curve
  FaceId number;      ///< in the input
  FaceVertices vertices;
  SideCodes twins;       ///< [side], of the input
  std::uint32_t firsts;  ///< one bit for each corner that is the first of its fan
  friend bool operator<(const KeyedFace& a, const KeyedFace& b) {
    return a.key != b.key ? a.key < b.key : a.number < b.number;
  }
};

/// A position, and the place of its vertex in the order in which corners name vertices.
struct PlacedPosition {
  std::uint64_t place;
  std::array<double, 3> position;
  friend bool operator<(const PlacedPosition& a, const PlacedPosition& b) {
    return a.place < b.place;
  }
};

/// Two numbers of 32 bits that are sorted by the first, then by the second.
using Pair = std::uint64_t;
constexpr Pair pair_of(std::uint32_t first, std::uint32_t second) {
  return Pair{first} << 32 | second;
}
constexpr std::uint32_t first_of(Pair pair) { return static_cast<std::uint32_t>(pair >> 32); }
constexpr std::uint32_t second_of(Pair pair) { return static_cast<std::uint32_t>(pair); }

/// Counts the records that passes have handled, and lets the caller cancel.
class Meter {
 public:
  explicit Meter(const ProgressCallback& progress) : progress_(&progress) {}

  void set_total(std::uint64_t total) { total_ = total; }
  void enter(std::string_view phase) {
    phase_ = phase;
    tell();
  }
  void add(std::uint64_t records = 1) {
    done_ += records;
    if (done_ < next_) return;
    next_ = done_ + kEvery;
    tell();
  }

 private:
  static constexpr std::uint64_t kEvery = std::uint64_t{1} << 16;

  void tell() const {
    if (*progress_ && !(*progress_)({phase_, std::min(done_, total_), total_}))
      throw Error(ErrorCode::kCancelled, fmt::format("layout: cancelled, {}", phase_));
  }

  const ProgressCallback* progress_;
  std::string_view phase_;
  std::uint64_t done_ = 0, next_ = kEvery, total_ = 0;
};

/// One layout. Each pass sorts what the next one reads, and drops what nobody reads any more.
class FileLayout final : private MeshSink {
 public:
  FileLayout(const FileLayoutRequest& request, const Directory& directory)
      : request_(request), in_(directory), meter_(request.progress) {}

  FileLayoutResult run();

 private:
  // Of order_faces_in_files.cpp: from the file of the mesh to the faces in their order.
  void begin(std::uint64_t vertices, std::uint64_t faces) override;
  void take(const IndexedMesh& part) override;
  void read_mesh();
  void match_sides();
  void give_keys();
  void order_faces();

  // Of lay_out_in_files.cpp: what follows from the order.
  void pair_sides();
  void number_edges();
  void write_face_edges();
  void write_vertex_corners();
  void find_first_corners();
  void write_codes();
  void write_positions();

  SortMemory share(std::uint64_t eighths) const {
    return {request_.memory.bytes / 8 * eighths, request_.memory.read_bytes};
  }
  template <class Record>
  void make(std::optional<ExternalSort<Record>>& sort, std::uint64_t eighths) {
    sort.emplace(in_, share(eighths));
  }
  /// After the last record was taken.
  template <class Record>
  void end(std::optional<ExternalSort<Record>>& sort) {
    result_.merged_runs += sort->merged_runs();
    sort.reset();
  }

  const FileLayoutRequest& request_;
  const Directory& in_;
  Meter meter_;
  FileLayoutResult result_;
  std::uint64_t face_count_ = 0;
  FaceVertices repeated_{};
  std::optional<FaceId> face_with_repeated_;
  GrowingBox box_;
  WordsOfPositions words_;
  bool keeps_order_ = true;

  std::optional<RecordFile<Vector3<double>>> input_positions_, positions_;
  std::optional<RecordFile<VertexId>> input_vertices_;
  std::optional<ExternalSort<CornerAtVertex>> at_vertices_;
  std::optional<ExternalSort<CornerOfFace>> of_faces_;
  std::optional<ExternalSort<KeyedFace>> keyed_faces_;
  std::optional<ExternalSort<Pair>> sides_;           ///< name of the edge, side
  std::optional<ExternalSort<Pair>> vertex_firsts_;   ///< vertex, its first corner
  std::optional<ExternalSort<Pair>> namings_;         ///< vertex, corner
  std::optional<ExternalSort<Pair>> edges_;           ///< turn of the first side, of the other one
  std::optional<ExternalSort<Pair>> edges_of_sides_;  ///< turn of the side, edge
  std::optional<ExternalSort<Pair>> first_namings_;   ///< corner, first corner of its vertex
  std::optional<RankedBits> new_vertices_;            ///< corners that name their vertex first
  std::optional<RecordFile<std::uint32_t>> first_corners_;  ///< [vertex]
  std::optional<ExternalSort<PlacedPosition>> placed_;
  std::optional<IndexWriter> index_;
  std::optional<PackedWriter> packed_;
};

PLAIT_END_NAMESPACE
