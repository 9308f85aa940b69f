#include "layout/spans.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>

#include "base/interruption.h"
#include "base/threads.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Counts stencils by their width. Widths are below the number of edges, so an array of counts
/// gives the median without sorting.
class WidthCounter {
 public:
  explicit WidthCounter(std::uint64_t edge_count) : count_of_width_(edge_count, 0) {}

  void add(EdgeId lowest, EdgeId highest) {
    ++count_of_width_[highest - lowest];
    sum_ += highest - lowest;
    ++stencil_count_;
  }

  StencilSpan result() const {
    StencilSpan result;
    if (stencil_count_ == 0) return result;
    result.mean_width = static_cast<double>(sum_) / static_cast<double>(stencil_count_);
    const std::uint64_t median_rank = (stencil_count_ - 1) / 2;
    std::uint64_t counted = 0;
    for (std::size_t width = 0; width < count_of_width_.size(); ++width) {
      if (count_of_width_[width] == 0) continue;
      if (counted <= median_rank) result.median_width = width;
      counted += count_of_width_[width];
      result.span = width;
    }
    return result;
  }

 private:
  std::vector<std::uint32_t> count_of_width_;
  std::uint64_t sum_ = 0, stencil_count_ = 0;
};

}  // namespace
PLAIT_END_NAMESPACE

namespace plait::layout {

std::vector<EdgeId> number_edges(const BaseMesh& mesh, std::span<const FaceId> order) {
  std::vector<EdgeId> number(mesh.edge_count(), kNoId);
  EdgeId next = 0;
  std::uint64_t turn = 0;
  for (const FaceId face : order) {
    if (is_turn_to_poll(++turn)) poll_interruption();
    for (const std::size_t side : {2u, 0u, 1u}) {
      EdgeId& edge_number = number[mesh.face_edges()[face][side]];
      if (edge_number == kNoId) edge_number = next++;
    }
  }
  return number;
}

LayoutSpans measure_spans(const BaseMesh& mesh, std::span<const EdgeId> number) {
  struct Interval {
    EdgeId lowest, highest;
  };
  std::vector<Interval> interval_of_face(mesh.face_count());
  WidthCounter face_widths(mesh.edge_count());
  for (FaceId face = 0; face < interval_of_face.size(); ++face) {
    if (is_turn_to_poll(face)) poll_interruption();
    const auto& edges = mesh.face_edges()[face];
    const auto [lowest, highest] =
        std::minmax({number[edges[0]], number[edges[1]], number[edges[2]]});
    interval_of_face[face] = {lowest, highest};
    face_widths.add(lowest, highest);
  }
  // The stencil of an edge is the edges of its two faces. Its interval is the union of theirs.
  WidthCounter loop_widths(mesh.edge_count());
  std::uint64_t turn = 0;
  for (const Edge& edge : mesh.edges()) {
    if (is_turn_to_poll(++turn)) poll_interruption();
    Interval stencil = interval_of_face[edge.own.face()];
    if (!edge.is_border()) {
      const Interval& other = interval_of_face[edge.other.face()];
      stencil.lowest = std::min(stencil.lowest, other.lowest);
      stencil.highest = std::max(stencil.highest, other.highest);
    }
    loop_widths.add(stencil.lowest, stencil.highest);
  }
  return {face_widths.result(), loop_widths.result()};
}

std::uint64_t measure_loop_span(const BaseMesh& mesh, std::span<const EdgeId> number) {
  constexpr std::size_t kGrain = 1 << 14;
  const std::span<const Edge> edges = mesh.edges();
  std::vector<EdgeId> widest((edges.size() + kGrain - 1) / kGrain, 0);
  const auto widen = [&](FaceId face, EdgeId& lowest, EdgeId& highest) {
    for (const EdgeId edge : mesh.face_edges()[face]) {
      lowest = std::min(lowest, number[edge]);
      highest = std::max(highest, number[edge]);
    }
  };
  each_on_workers(std::size_t{0}, widest.size(), [&](std::size_t part) {
    poll_interruption();
    EdgeId most = 0;
    for (std::size_t edge = part * kGrain; edge < std::min((part + 1) * kGrain, edges.size());
         ++edge) {
      EdgeId lowest = kNoId, highest = 0;
      widen(edges[edge].own.face(), lowest, highest);
      if (!edges[edge].is_border()) widen(edges[edge].other.face(), lowest, highest);
      most = std::max(most, highest - lowest);
    }
    widest[part] = most;
  });
  return widest.empty() ? 0 : *std::ranges::max_element(widest);
}

}  // namespace plait::layout

PLAIT_BEGIN_PRIVATE_NAMESPACE

LayoutSpans measure_spans(const BaseMesh& mesh) {
  std::vector<EdgeId> number(mesh.edge_count());
  std::iota(number.begin(), number.end(), EdgeId{0});
  return layout::measure_spans(mesh, number);
}

std::uint64_t window_bytes(std::uint64_t span, int level, std::uint64_t record_bytes) {
  if (level < 0 || level > kMaxLevel)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("window size: expected a level of 0 to {}, found {}", kMaxLevel, level));
  // Levels 1 to `level` have 1 + 4 + ... + 4^(level-1) records per edge.
  const std::uint64_t records_per_edge = ((std::uint64_t{1} << (2 * level)) - 1) / 3;
  std::uint64_t bytes = 0;
  if (__builtin_mul_overflow(2 * records_per_edge, span, &bytes) ||
      __builtin_mul_overflow(bytes, record_bytes, &bytes))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("window size: a span of {} edges at level {} with {} bytes a record "
                            "does not fit 64 bits",
                            span, level, record_bytes));
  return bytes;
}

PLAIT_END_NAMESPACE
