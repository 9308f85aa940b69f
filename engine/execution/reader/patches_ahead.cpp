// Prefetching of patches, and reading them ahead.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <span>

#include "execution/reader/reader_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// As many patches are read ahead at most.
constexpr std::size_t kMostAhead = 64;

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

PLAIT_END_NAMESPACE
