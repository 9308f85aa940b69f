#include "format/base_index_pages.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "base/threads.h"
#include "format/byte_order.h"
#include "format/checksum.h"
#include "io/huge_pages.h"
#include "mesh/connectivity.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Elements and pages that a thread takes at once.
constexpr std::size_t kElementsAtOnce = std::size_t{1} << 14, kPagesAtOnce = 8;

template <class Element>
std::span<const Element> elements(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const Element*>(bytes.data()), bytes.size() / sizeof(Element)};
}

std::size_t element_bytes(MeshArray array) {
  switch (array) {
    case MeshArray::kPositions:
      return sizeof(Vector3<double>);
    case MeshArray::kFaces:
    case MeshArray::kFaceEdges:
      return sizeof(std::array<std::uint32_t, 3>);
    case MeshArray::kEdges:
      return sizeof(Edge);
    case MeshArray::kVertexCorners:
    case MeshArray::kBorderEdges:
    case MeshArray::kInputVertices:
    case MeshArray::kInputFaces:
      break;
  }
  return sizeof(std::uint32_t);
}

}  // namespace

BaseIndexPages::Reservation::Reservation(std::uint64_t bytes) : bytes_(bytes) {
  if (bytes == 0) return;
  void* const mapped = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                              MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (mapped == MAP_FAILED)
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("reserve addresses for a base mesh of {} bytes", bytes));
  data_ = static_cast<std::byte*>(mapped);
}

BaseIndexPages::Reservation::~Reservation() {
  if (data_ != nullptr) ::munmap(data_, bytes_);
}

BaseIndexPages::Reservation::Reservation(Reservation&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}

BaseIndexPages::Reservation& BaseIndexPages::Reservation::operator=(Reservation&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(bytes_, other.bytes_);
  return *this;
}

void BaseIndexPages::refuse(std::uint64_t offset, const std::string& what) const {
  throw Error(ErrorCode::kCorruption,
              fmt::format("read {}: byte {}: {}{}", file_.path().native(), offset, what, cure_))
      .about(file_.path(), offset);
}

void BaseIndexPages::refuse(MeshArray array, std::uint64_t element, const std::string& what) const {
  refuse(layout_.place(array).offset + element_bytes(array) * element, what);
}

StoredBase BaseIndexPages::stored() const noexcept {
  if (!base_mesh_.is_open()) return {};
  return {&base_mesh_, &file_, base_mesh_checksum_};
}

BaseIndexPages::BaseIndexPages(File file, const ExpectedBase& expected, File base_mesh)
    : file_(std::move(file)),
      base_mesh_(std::move(base_mesh)),
      base_mesh_checksum_(expected.checksum),
      cure_(expected.cure),
      counts_(expected.counts),
      layout_({}, {}) {
  read_head(expected);
  memory_ = Reservation(layout_.file_bytes() - layout_.place(MeshArray::kPositions).offset);
  ready_ = std::make_unique<std::atomic<bool>[]>(layout_.page_count());
  arrays_.positions = array<Vector3<double>>(MeshArray::kPositions);
  arrays_.mesh = {array<std::array<VertexId, 3>>(MeshArray::kFaces),
                  array<std::array<EdgeId, 3>>(MeshArray::kFaceEdges),
                  array<Edge>(MeshArray::kEdges), array<FaceSide>(MeshArray::kVertexCorners),
                  array<EdgeId>(MeshArray::kBorderEdges)};
  arrays_.input_vertices = array<VertexId>(MeshArray::kInputVertices);
  arrays_.input_faces = array<std::uint32_t>(MeshArray::kInputFaces);
  need(MeshArray::kBorderEdges);
  check_border();
}

void BaseIndexPages::read_head(const ExpectedBase& expected) {
  std::array<std::byte, kIndexHeaderBytes> header;
  const std::uint64_t size = file_.size();
  if (size < header.size())
    refuse(0, fmt::format("expected the head of a base index, found {} bytes", size));
  file_.read_at(0, header);
  const std::uint32_t maps = load<std::uint32_t>(header, kIndexMapsAt);
  if (std::memcmp(header.data(), kIndexMagic, 8) != 0 ||
      load<std::uint32_t>(header, 8) != kIndexFormat || maps > 3)
    refuse(0, "expected the head of a base index");
  const auto count = [&](std::size_t number) {
    return load<std::uint64_t>(header, kIndexCountsAt + 8 * number);
  };
  if (const BaseCounts found{count(0), count(1), count(2), count(3)}; found != counts_)
    refuse(kIndexCountsAt,
           fmt::format("expected {} vertices, {} edges, {} faces and {} border edges, found {}, "
                       "{}, {} and {}",
                       counts_.vertices, counts_.edges, counts_.faces, counts_.border_edges,
                       found.vertices, found.edges, found.faces, found.border_edges));
  if (const auto found = load<std::uint64_t>(header, kIndexBaseMeshAt); found != expected.checksum)
    refuse(kIndexBaseMeshAt, fmt::format("it follows from another base.mesh: expected one of "
                                         "checksum {:016x}, found {:016x}",
                                         expected.checksum, found));
  if (counts_.faces > kMaxFaces || 3 * counts_.faces + counts_.border_edges != 2 * counts_.edges)
    refuse(kIndexCountsAt, fmt::format("no mesh has {} faces, {} edges and {} border edges",
                                       counts_.faces, counts_.edges, counts_.border_edges));
  layout_ = BaseIndexLayout(counts_, {(maps & 1) != 0, (maps & 2) != 0});
  if (size != layout_.file_bytes())
    refuse(0, fmt::format("{} bytes, expected {}", size, layout_.file_bytes()));
  std::vector<std::byte> head(layout_.head_bytes());
  file_.read_at(0, head);
  const std::size_t content = head.size() - 8;
  const std::uint64_t found = checksum_of(std::span(head).first(content));
  if (const auto said = load<std::uint64_t>(head, content); found != said)
    refuse(0, fmt::format("checksum of the head {:016x}, expected {:016x}", found, said));
  arrays_.input_vertex_count = load<std::uint64_t>(head, kIndexInputVerticesAt);
  if (arrays_.input_vertex_count >= kNoId ||
      ((maps & 1) == 0 && arrays_.input_vertex_count != counts_.vertices))
    refuse(kIndexInputVerticesAt,
           fmt::format("{} vertices of the input cannot be", arrays_.input_vertex_count));
  checksums_.resize(layout_.page_count());
  std::memcpy(checksums_.data(), &head[kIndexHeaderBytes], 8 * checksums_.size());
}

std::byte* BaseIndexPages::memory_of(MeshArray array) const noexcept {
  return memory_.data() +
         (layout_.place(array).offset - layout_.place(MeshArray::kPositions).offset);
}

template <class Element>
std::span<const Element> BaseIndexPages::array(MeshArray which) const noexcept {
  return {reinterpret_cast<const Element*>(memory_of(which)),
          layout_.place(which).bytes / sizeof(Element)};
}

void BaseIndexPages::need_page(MeshArray array, std::uint64_t page) const {
  const BaseIndexLayout::Place& place = layout_.place(array);
  const std::uint64_t number = place.first_page + page;
  if (ready_[number].load(std::memory_order_acquire)) return;
  const std::lock_guard lock(locks_[number % kLocks]);
  if (ready_[number].load(std::memory_order_relaxed)) return;
  const std::uint64_t first = page * kIndexPageBytes;
  const std::span<std::byte> bytes(memory_of(array) + first,
                                   std::min(kIndexPageBytes, place.bytes - first));
  file_.read_at(place.offset + first, bytes);
  if (const std::uint64_t found = checksum_of(bytes); found != checksums_[number])
    refuse(place.offset + first, fmt::format("checksum of the page {:016x}, expected {:016x}",
                                             found, checksums_[number]));
  check_page(array, first, bytes);
  read_bytes_.fetch_add(bytes.size(), std::memory_order_relaxed);
  ready_[number].store(true, std::memory_order_release);
}

void BaseIndexPages::check_page(MeshArray array, std::uint64_t first,
                                std::span<const std::byte> bytes) const {
  const std::uint64_t offset = layout_.place(array).offset + first;
  // The largest number is found without a branch for each of them.
  const auto check_below = [&](std::uint64_t limit, const char* what) {
    std::uint32_t largest = 0;
    for (const std::uint32_t number : elements<std::uint32_t>(bytes))
      largest = std::max(largest, number);
    if (largest >= limit)
      refuse(offset, fmt::format("expected {} below {}, found {}", what, limit, largest));
  };
  switch (array) {
    case MeshArray::kPositions:
      for (const double coordinate : elements<double>(bytes))
        if (!std::isfinite(coordinate)) refuse(offset, "a coordinate is not a finite number");
      break;
    case MeshArray::kFaces:
      return check_below(counts_.vertices, "vertices");
    case MeshArray::kFaceEdges:
      return check_below(counts_.edges, "edges");
    case MeshArray::kEdges:
      for (const Edge& edge : elements<Edge>(bytes))
        if (std::max(edge.start, edge.end) >= counts_.vertices ||
            edge.own.code >= 3 * counts_.faces ||
            (edge.other.exists() && edge.other.code >= 3 * counts_.faces))
          refuse(offset, "an edge names a vertex or a face that is not there");
      break;
    case MeshArray::kVertexCorners:
      return check_below(3 * counts_.faces, "corners");
    case MeshArray::kBorderEdges:
      return check_below(counts_.edges, "edges");
    case MeshArray::kInputVertices:
      for (const VertexId vertex : elements<VertexId>(bytes))
        if (vertex != kNoId && vertex >= arrays_.input_vertex_count)
          refuse(offset, fmt::format("expected vertices of the input below {}, found {}",
                                     arrays_.input_vertex_count, vertex));
      break;
    case MeshArray::kInputFaces:
      return check_below(2 * counts_.faces, "faces of the input");
  }
}

void BaseIndexPages::check_border() const {
  const std::span<const EdgeId> border = arrays_.mesh.border_edges;
  if (std::ranges::adjacent_find(border, std::ranges::greater_equal()) != border.end())
    refuse(layout_.place(MeshArray::kBorderEdges).offset, "the border edges do not ascend");
}

void BaseIndexPages::need(MeshArray array) const {
  std::atomic<bool>& whole = whole_[static_cast<std::size_t>(array)];
  if (whole.load(std::memory_order_acquire)) return;
  const BaseIndexLayout::Place& place = layout_.place(array);
  wish_huge_pages(memory_of(array), place.bytes);
  ranges_on_workers(place.page_count(), kPagesAtOnce, [&](std::size_t first, std::size_t last) {
    for (std::size_t page = first; page < last; ++page) need_page(array, page);
  });
  whole.store(true, std::memory_order_release);
}

void BaseIndexPages::check_side(FaceSide side) const {
  const Topology& mesh = arrays_.mesh;
  const auto at = static_cast<std::size_t>(side.side());
  const EdgeId number = mesh.face_edges[side.face()][at];
  const Edge& edge = mesh.edges[number];
  const std::array<VertexId, 3>& corners = mesh.faces[side.face()];
  const VertexId from = corners[(at + 1) % 3], to = corners[(at + 2) % 3];
  const bool is_own = edge.own == side && edge.start == from && edge.end == to;
  const bool is_other = edge.other == side && edge.start == to && edge.end == from;
  if (is_own == is_other || from == to)
    refuse(MeshArray::kEdges, number,
           fmt::format("edge {} does not agree with side {} of face {}", number, side.side(),
                       side.face()));
}

void BaseIndexPages::check_sides(FaceId face) const {
  for (int side = 0; side < 3; ++side) check_side(FaceSide(face, side));
}

void BaseIndexPages::need_topology() const {
  if (topology_whole_.load(std::memory_order_acquire)) return;
  for (const MeshArray array : {MeshArray::kFaces, MeshArray::kFaceEdges, MeshArray::kEdges,
                                MeshArray::kVertexCorners, MeshArray::kBorderEdges})
    need(array);
  const Topology& mesh = arrays_.mesh;
  // Each side is one of the two of its edge, and there are as many sides as edges have (read_head()
  // compares the counts): so each is that of one edge, and Topology::across() goes back and forth.
  ranges_on_workers(mesh.faces.size(), kElementsAtOnce, [&](std::size_t first, std::size_t last) {
    for (std::size_t face = first; face < last; ++face) check_sides(static_cast<FaceId>(face));
  });
  ranges_on_workers(mesh.edges.size(), kElementsAtOnce, [&](std::size_t first, std::size_t last) {
    auto border = std::ranges::lower_bound(mesh.border_edges, static_cast<EdgeId>(first));
    for (std::size_t edge = first; edge < last; ++edge) {
      const bool is_listed = border != mesh.border_edges.end() && *border == edge;
      border += is_listed ? 1 : 0;
      if (mesh.edges[edge].is_border() != is_listed)
        refuse(MeshArray::kEdges, edge,
               fmt::format("edge {}: the list of border edges says another thing", edge));
    }
  });
  ranges_on_workers(
      mesh.vertex_corners.size(), kElementsAtOnce, [&](std::size_t first, std::size_t last) {
        for (std::size_t vertex = first; vertex < last; ++vertex) {
          const FaceSide corner = mesh.vertex_corners[vertex];
          if (mesh.faces[corner.face()][static_cast<std::size_t>(corner.side())] != vertex)
            refuse(MeshArray::kVertexCorners, vertex,
                   fmt::format("vertex {} is not at its corner", vertex));
        }
      });
  topology_whole_.store(true, std::memory_order_release);
}

void BaseIndexPages::need_element(MeshArray array, std::uint64_t index) const {
  need_range(array, index, index + 1);
}

void BaseIndexPages::need_elements(MeshArray array, std::span<const std::uint32_t> elements) const {
  // Elements of a region are close together: most are on the page of the one before.
  const std::uint64_t bytes = element_bytes(array);
  std::uint64_t last_page = ~std::uint64_t{0};
  for (const std::uint32_t element : elements) {
    const std::uint64_t first = element * bytes / kIndexPageBytes,
                        end = ((element + std::uint64_t{1}) * bytes - 1) / kIndexPageBytes;
    if (first == last_page && end == last_page) continue;
    for (std::uint64_t page = first; page <= end; ++page) need_page(array, page);
    last_page = end;
  }
}

void BaseIndexPages::need_range(MeshArray array, std::uint64_t first, std::uint64_t after) const {
  if (first >= after) return;
  const std::uint64_t bytes = element_bytes(array);
  for (std::uint64_t page = first * bytes / kIndexPageBytes;
       page <= (after * bytes - 1) / kIndexPageBytes; ++page)
    need_page(array, page);
}

void BaseIndexPages::forget(MeshArray array, std::uint64_t first, std::uint64_t after) const {
  if (first >= after) return;
  const BaseIndexLayout::Place& place = layout_.place(array);
  const std::uint64_t bytes = element_bytes(array), first_page = first * bytes / kIndexPageBytes,
                      page_after = (after * bytes - 1) / kIndexPageBytes + 1;
  whole_[static_cast<std::size_t>(array)].store(false, std::memory_order_relaxed);
  topology_whole_.store(false, std::memory_order_relaxed);
  for (std::uint64_t page = first_page; page < page_after; ++page) {
    const std::uint64_t start = page * kIndexPageBytes;
    if (ready_[place.first_page + page].exchange(false, std::memory_order_relaxed))
      read_bytes_.fetch_sub(std::min(kIndexPageBytes, place.bytes - start),
                            std::memory_order_relaxed);
  }
  // Whole pages of the system: others may have a piece of the next array.
  static const auto system_page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const auto start =
                 reinterpret_cast<std::uintptr_t>(memory_of(array)) + first_page * kIndexPageBytes,
             end = reinterpret_cast<std::uintptr_t>(memory_of(array)) +
                   std::min(page_after * kIndexPageBytes, place.bytes);
  const std::uintptr_t from = (start + system_page - 1) / system_page * system_page,
                       to = end / system_page * system_page;
  if (from < to) ::madvise(reinterpret_cast<void*>(from), to - from, MADV_DONTNEED);
}

void BaseIndexPages::check_sides(std::span<const FaceId> faces) const {
  for (const FaceId face : faces) check_sides(face);
}

void BaseIndexPages::need_face(FaceId face) const {
  if (topology_whole_.load(std::memory_order_acquire)) return;
  const Topology& mesh = arrays_.mesh;
  need_element(MeshArray::kFaces, face);
  need_element(MeshArray::kFaceEdges, face);
  for (const EdgeId number : mesh.face_edges[face]) {
    need_element(MeshArray::kEdges, number);
    if (mesh.edges[number].is_border() != std::ranges::binary_search(mesh.border_edges, number))
      refuse(MeshArray::kEdges, number,
             fmt::format("edge {}: the list of border edges says another thing", number));
  }
  check_sides(face);
}

std::uint64_t BaseIndexPages::memory_bytes() const noexcept {
  return read_bytes_.load(std::memory_order_relaxed) + 9 * checksums_.size();
}

PLAIT_END_NAMESPACE
