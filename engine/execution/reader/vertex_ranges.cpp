// What a Reader knows of the vertices of a level by their numbers, and reads of them.

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "execution/reader/reader_state.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// As many blocks of a range of vertices are read ahead. docs/backends.md has the measurement.
constexpr std::uint64_t kRunsAhead = 3;

}  // namespace

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

PLAIT_END_NAMESPACE
