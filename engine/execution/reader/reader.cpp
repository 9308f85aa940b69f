#include "plait/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <boost/container/small_vector.hpp>
#include <cstring>
#include <limits>
#include <utility>

#include "address/record_sizes.h"
#include "execution/reader/reader_state.h"
#include "plait/detail/face_depths.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/pager.h"
#include "plait/extend/store_access.h"
#include "plait/extend/vertex_numbering.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// As many patches are read ahead at most.
constexpr std::size_t kMostAhead = 64;

/// As many blocks of a range of vertices are read ahead. docs/backends.md has the measurement.
constexpr std::uint64_t kRunsAhead = 3;

/// Lets state.mesh be read for the face. False if base.index is damaged there: reading the patch
/// says so.
template <class State>
bool bring_in(const State& state, FaceId face) noexcept {
  try {
    state.store->base.need_face(face);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

/// Asks for the blocks of these patches, kMostAhead at most, until `ask` refuses one. Returns how
/// many patches have got all of their blocks.
template <class State, class Ask>
std::size_t ask_for_blocks(const State& state, std::span<const FaceId> faces, int level,
                           Ask ask) noexcept {
  const int refinements = level - state.base_level;
  if (!state.store->process.is_current() || refinements < 0) return 0;
  const std::size_t most = std::min(faces.size(), kMostAhead);
  for (std::size_t at = 0; at < most; ++at) {
    if (faces[at] >= state.mesh.faces.size() || level > state.depth(faces[at]) ||
        !bring_in(state, faces[at]))
      return at;
    for (const auto& attribute : state.attributes) {
      if (attribute.levels.size() < static_cast<std::size_t>(refinements)) return at;
      for (const LevelFile* const file :
           std::span(attribute.levels).first(static_cast<std::size_t>(refinements)))
        for (const EdgeId edge : state.mesh.face_edges[faces[at]])
          if (!ask(*file, file->geometry.block_of(edge))) return at;
    }
  }
  return most;
}

}  // namespace

Reader::State::State(const Store& of, const ReaderOptions& options)
    : store((of.state(), of.implementation_)),
      mesh(of.base().arrays().mesh),
      base_level(of.base_level()) {
  const auto add = [&](AttributeId id) {
    const AttributeInfo& info = of.attributes()[id];
    const auto& stored = store->attributes[id];
    Attribute read{id, info.schema, info.finest_level, stored.base_bytes, stored.base_written.get(),
                   {}};
    for (int level = base_level + 1; level <= info.finest_level; ++level)
      read.levels.push_back(&StoreAccess::level_file(of, id, level));
    attributes.push_back(std::move(read));
  };
  for (const std::string& name : options.attributes) add(of.attribute(name));
  if (options.attributes.empty())
    for (AttributeId id = 0; id < of.attributes().size(); ++id) add(id);
  trees.resize(attributes.size());
  session =
      StoreAccess::open_session(of, {.policy = options.policy, .share_bytes = options.share_bytes});
}

const Reader::State::Attribute* Reader::State::find(std::string_view name) const {
  const auto found = std::ranges::find(
      attributes, name, [](const Attribute& each) -> std::string_view { return each.schema.name; });
  return found == attributes.end() ? nullptr : &*found;
}

void Reader::State::check_level(const Attribute& attribute, int level) const {
  if (level < base_level || level > attribute.finest_level)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("read level {} of '{}': expected {} to {}", level,
                            attribute.schema.name, base_level, attribute.finest_level));
}

int Reader::State::depth(FaceId face) const noexcept {
  const FaceDepths* const depths = store->base.depths();
  return depths == nullptr ? kMaxLevel : base_level + depths->of(face);
}

void Reader::State::refuse_depth(FaceId face, int level) const {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("read level {} of face {}: expected {} to {}, the depth of the face",
                          level, face, base_level, depth(face)));
}

void Reader::State::check_finished(const Attribute& attribute, int level) const {
  const WrittenRecords& records = level == base_level
                                      ? *attribute.base_written
                                      : *attribute.levels[static_cast<std::size_t>(
                                            relative_to_base(level, base_level).refinements - 1)];
  if (!records.is_finished()) [[unlikely]]
    refuse_unfinished(*store, attribute.schema.name, records, level);
}

std::size_t Reader::State::number_of(std::string_view name) const {
  const Attribute* const found = find(name);
  if (!found)
    throw Error(ErrorCode::kNotFound,
                fmt::format("{}: the reader reads no attribute '{}'", store->path.native(), name));
  return static_cast<std::size_t>(found - attributes.data());
}

std::size_t Reader::State::number_of(std::string_view name, ComponentType type,
                                     std::uint32_t components) const {
  const std::size_t number = number_of(name);
  const AttributeSchema& schema = attributes[number].schema;
  if (schema.type != type || schema.components != components)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("attribute '{}' holds {} x {}, asked for {} x {}", schema.name,
                    to_string(schema.type), schema.components, to_string(type), components));
  return number;
}

struct PatchView::Content {
  Content(std::shared_ptr<const Reader::State> of, FaceId of_face, int of_level)
      : state(std::move(of)), face(of_face), level(of_level), slots(state->attributes.size()) {
    ++state->store->view_count;
  }
  ~Content() {
    PinnedBlock::release_all({pins.data(), pins.size()});
    --state->store->view_count;
  }
  Content(const Content&) = delete;
  Content& operator=(const Content&) = delete;

  int refinements() const { return relative_to_base(level, state->base_level).refinements; }

  std::shared_ptr<const Reader::State> state;  ///< outlives the pins
  FaceId face;
  int level;
  std::vector<FaceSlots> slots;  ///< [attribute of the reader]
  boost::container::small_vector<PinnedBlock, 16> pins;
};

PatchView::PatchView() noexcept = default;
PatchView::~PatchView() = default;
PatchView::PatchView(PatchView&&) noexcept = default;
PatchView& PatchView::operator=(PatchView&&) noexcept = default;

FaceId PatchView::face() const noexcept { return content_->face; }
int PatchView::level() const noexcept { return content_->level; }
int PatchView::refinements() const noexcept { return content_->refinements(); }
std::int64_t PatchView::size() const noexcept { return std::int64_t{1} << refinements(); }

const FaceSlots& PatchView::slots_of(std::string_view name, ComponentType type,
                                     std::uint32_t components) const {
  return content_->slots[content_->state->number_of(name, type, components)];
}

std::shared_ptr<const void> PatchView::release() {
  return with_memory_errors("keep a patch",
                            [&] { return std::shared_ptr<const Content>(std::move(content_)); });
}

RecordView PatchView::records(std::string_view name) && {
  RecordView view = std::as_const(*this).records(name);
  view.pins_ = release();
  return view;
}

RecordView PatchView::records(std::string_view name) const& {
  const std::size_t number = content_->state->number_of(name);
  return {content_->slots[number], face(), refinements(),
          content_->state->attributes[number].schema.record_bytes()};
}

std::span<const std::byte> RecordView::at(std::int64_t i, std::int64_t j) const {
  if ((i | j | (size_ - i - j)) < 0) refuse_point(face_, size_, i, j);
  return {slots_->find(refinements_, i, j), record_bytes_};
}

void RecordView::copy_to(std::span<std::byte> to) const {
  if (to.size() != patch_vertex_count(size_) * record_bytes_)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("copy face {}: expected room for {} records of {} bytes, found {} bytes", face_,
                    patch_vertex_count(size_), record_bytes_, to.size()));
  const bool copied = with_record_size(record_bytes_, [&](auto record) {
    slots_->copy_to(refinements_, reinterpret_cast<decltype(record)*>(to.data()));
  });
  if (copied) return;
  std::byte* next = to.data();
  for (std::int64_t j = 0; j <= size_; ++j)
    for (std::int64_t i = 0; i + j <= size_; ++i, next += record_bytes_)
      std::memcpy(next, slots_->find(refinements_, i, j), record_bytes_);
}

void refuse_point(FaceId face, std::int64_t size, std::int64_t i, std::int64_t j) {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("face {}: expected a point in the grid of size {}, found ({}, {})", face,
                          size, i, j));
}

void check_count(FaceId face, std::int64_t size, std::size_t count) {
  if (count != patch_vertex_count(size))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("copy face {}: expected room for {} records, found {}", face,
                            patch_vertex_count(size), count));
}

Reader::Reader(const Store& store, const ReaderOptions& options) {
  with_memory_errors("open a reader", [&] {
    const auto counted = std::make_shared<const Counted>(std::make_shared<State>(store, options));
    state_ = {counted, counted->state.get()};
  });
}

Reader::~Reader() = default;
Reader::Reader(Reader&&) noexcept = default;
Reader& Reader::operator=(Reader&&) noexcept = default;

PatchView Reader::read_patch(FaceId face, int level) const try {
  state_->check_usable();
  if (face >= state_->mesh.faces.size())
    throw Error(ErrorCode::kInvalidArgument, fmt::format("read face {}: expected a face below {}",
                                                         face, state_->mesh.faces.size()));
  state_->check_depth(face, level);
  state_->store->base.need_face(face);
  for (const State::Attribute& attribute : state_->attributes) {
    state_->check_level(attribute, level);
    for (int needed = state_->base_level; needed <= level; ++needed)
      state_->check_finished(attribute, needed);
  }
  PatchView view;
  view.content_ = std::make_unique<PatchView::Content>(state_->share(), face, level);
  PatchView::Content& content = *view.content_;
  const auto levels = static_cast<std::size_t>(content.refinements());
  const std::array<EdgeId, 3>& edges = state_->mesh.face_edges[face];

  // Edges of a face are often in one block, which one pin keeps.
  boost::container::small_vector<BlockRequest, 48> requests;
  boost::container::small_vector<std::array<std::size_t, 3>, 16> request_of;
  for (const State::Attribute& attribute : state_->attributes)
    for (std::size_t level_at = 0; level_at < levels; ++level_at) {
      const LevelFile& file = *attribute.levels[level_at];
      const std::size_t first = requests.size();
      std::array<std::size_t, 3>& of_sides = request_of.emplace_back();
      for (std::size_t side = 0; side < 3; ++side) {
        const std::uint64_t block = file.geometry.block_of(edges[side]);
        std::size_t at = first;
        while (at < requests.size() && requests[at].block() != block) ++at;
        if (at == requests.size()) requests.emplace_back(file, block);
        of_sides[side] = at;
      }
    }
  content.pins.resize(requests.size());
  try {
    Session& session = state_->session;
    session.pin_many({requests.data(), requests.size()},
                     {content.pins.data(), content.pins.size()});
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kBudget) throw;
    throw Error(ErrorCode::kBudget,
                fmt::format("{}; {} view{} of patches {} open", error.what(), view_count() - 1,
                            view_count() == 2 ? "" : "s", view_count() == 2 ? "is" : "are"));
  }

  std::array<bool, 3> own;
  for (int side = 0; side < 3; ++side)
    own[static_cast<std::size_t>(side)] = state_->mesh.is_own(face, side);
  auto of_sides = request_of.begin();
  for (std::size_t number = 0; number < state_->attributes.size(); ++number) {
    const State::Attribute& attribute = state_->attributes[number];
    const std::size_t record_bytes = attribute.schema.record_bytes();
    FaceSlots& slots = content.slots[number];
    slots.set_corners(state_->mesh, face, 0, const_cast<std::byte*>(attribute.base_bytes.data()),
                      record_bytes);
    for (std::size_t level_at = 0; level_at < levels; ++level_at, ++of_sides)
      for (int side = 0; side < 3; ++side) {
        const auto side_at = static_cast<std::size_t>(side);
        const LevelGeometry& geometry = attribute.levels[level_at]->geometry;
        const Slot slot = geometry.slot(edges[side_at]);
        const std::size_t request = (*of_sides)[side_at];
        const std::span<std::byte> bytes = content.pins[request].bytes().subspan(
            slot.offset - geometry.block_offset(requests[request].block()), slot.bytes);
        slots.set(side, static_cast<int>(level_at) + 1, {bytes, slot.shape}, own[side_at],
                  record_bytes);
      }
  }
  return view;
} catch (const std::bad_alloc&) {
  throw out_of_memory("read a patch");
}

int Reader::depth(FaceId face) const {
  state_->check_usable();
  if (face >= state_->mesh.faces.size())
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("depth of face {}: expected a face below {}", face, state_->mesh.faces.size()));
  int depth = state_->depth(face);
  for (const State::Attribute& attribute : state_->attributes)
    depth = std::min(depth, attribute.finest_level);
  return depth;
}

std::optional<int> Reader::depth_across(FaceId face, int side) const {
  depth(face);  // refuses faces that are not there
  if (side < 0 || side > 2)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("depth across side {}: expected a side from 0 to 2", side));
  state_->store->base.need_face(face);
  const FaceSide beyond = state_->mesh.across(FaceSide(face, side));
  if (!beyond.exists()) return std::nullopt;
  return depth(beyond.face());
}

std::size_t Reader::prefetch(std::span<const FaceId> faces, int level) const noexcept {
  return ask_for_blocks(*state_, faces, level, [&](const LevelFile& file, std::uint64_t block) {
    return state_->session.prefetch(file, block);
  });
}

std::size_t Reader::read_ahead(std::span<const FaceId> faces, int level) const noexcept {
  return ask_for_blocks(*state_, faces, level, [&](const LevelFile& file, std::uint64_t block) {
    return state_->session.read_ahead(file, block);
  });
}

void Reader::end_prefetch() const noexcept { state_->session.end_prefetch(); }

std::vector<std::array<std::uint32_t, 3>> Reader::patch_indices(int level) const {
  const int refinements = relative_to_base(level, state_->base_level).refinements;
  constexpr int kMost = 15;  // the list has 12 GiB; after one refinement more it would have 48 GiB
  if (refinements < 0 || refinements > kMost)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("list the triangles of a patch at level {}: expected {} to {}", level,
                            state_->base_level, state_->base_level + kMost));
  const std::int64_t size = std::int64_t{1} << refinements;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  triangles.reserve(std::size_t{1} << (2 * refinements));
  for_each_triangle(refinements, [&](const std::array<FacePoint, 3>& corners) {
    std::array<std::uint32_t, 3>& triangle = triangles.emplace_back();
    for (std::size_t corner = 0; corner < 3; ++corner)
      triangle[corner] =
          static_cast<std::uint32_t>(patch_vertex(size, corners[corner].i, corners[corner].j));
  });
  return triangles;
}

std::vector<std::uint64_t> Reader::block_starts(std::string_view attribute, int level) const {
  const State::Attribute& of = state_->attributes[number_of(attribute)];
  state_->check_level(of, level);
  if (level == state_->base_level) return {0};
  const LevelGeometry& geometry =
      of.levels[static_cast<std::size_t>(relative_to_base(level, state_->base_level).refinements -
                                         1)]
          ->geometry;
  std::vector<std::uint64_t> starts(geometry.block_count());
  for (std::uint64_t block = 0; block < starts.size(); ++block)
    starts[block] = geometry.block_offset(block) / of.schema.record_bytes();
  return starts;
}

std::uint64_t Reader::vertex_count(int level) const {
  const BaseMesh& base = state_->store->base;
  if (level == state_->base_level) return base.vertex_count();
  return base.geometry(relative_to_base(level, state_->base_level), 1, 1).total_bytes();
}

std::size_t Reader::number_of(std::string_view attribute) const {
  return state_->number_of(attribute);
}

std::size_t Reader::record_bytes(std::size_t number) const noexcept {
  return state_->attributes[number].schema.record_bytes();
}

std::size_t Reader::number_of(std::string_view attribute, ComponentType type,
                              std::uint32_t components) const {
  return state_->number_of(attribute, type, components);
}

void Reader::check_range(std::size_t number, int level, std::uint64_t first,
                         std::uint64_t count) const {
  state_->check_usable();
  state_->check_level(state_->attributes[number], level);
  state_->check_finished(state_->attributes[number], level);
  const std::uint64_t there = vertex_count(level);
  if (first > there || count > there - first)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("read level {} of '{}': expected vertices below {}, found {} from {}",
                            level, state_->attributes[number].schema.name, there, count, first));
}

std::span<const std::byte> Reader::read_vertices(std::size_t number, int level, std::uint64_t first,
                                                 std::uint64_t count, PinnedBlock& pinned) const {
  const State::Attribute& attribute = state_->attributes[number];
  const std::size_t record_bytes = attribute.schema.record_bytes();
  if (level == state_->base_level)
    return attribute.base_bytes.subspan(first * record_bytes, count * record_bytes);
  const LevelFile& file = *attribute.levels[static_cast<std::size_t>(
      relative_to_base(level, state_->base_level).refinements - 1)];
  const LevelGeometry& geometry = file.geometry;
  const std::uint64_t offset = first * record_bytes;
  const std::uint64_t block = geometry.block_at(offset);
  // A backend that reads past the page cache would wait for each block on its own otherwise. The
  // first pin waits while the next blocks are read, so they begin before it.
  const std::uint64_t last = geometry.block_at(offset + count * record_bytes - 1);
  const std::uint64_t end = std::min(last, block + (kRunsAhead << file.run_log2)) + 1;
  for (std::uint64_t next = block + 1; next < end; ++next)
    if (!state_->session.read_ahead(file, next, end - next)) break;
  pinned = state_->session.pin(file, block);
  const std::uint64_t begin = offset - geometry.block_offset(block);
  return std::span<const std::byte>(pinned.bytes())
      .subspan(begin, std::min(geometry.block_bytes(block) - begin, count * record_bytes));
}

std::uint64_t Reader::view_count() const noexcept { return state_->store->view_count; }
PagingStatistics Reader::statistics() const { return state_->session.statistics(); }

PLAIT_END_NAMESPACE
