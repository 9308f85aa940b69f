#include "plait/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/container/small_vector.hpp>
#include <new>
#include <utility>

#include "execution/reader/reader_state.h"
#include "plait/detail/face_depths.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/pager.h"
#include "plait/extend/store_access.h"
#include "plait/extend/vertex_numbering.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

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

std::uint64_t Reader::view_count() const noexcept { return state_->store->view_count; }
PagingStatistics Reader::statistics() const { return state_->session.statistics(); }

PLAIT_END_NAMESPACE
