// Reader::pin_vertices: records where they are in memory, without a copy.
#include <fmt/format.h>

#include <utility>
#include <vector>

#include "execution/reader/reader_state.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct PinnedVertices::Content {
  explicit Content(std::shared_ptr<const Reader::State> of) : state(std::move(of)) {
    ++state->store->view_count;
  }
  ~Content() {
    PinnedBlock::release_all(pins);
    --state->store->view_count;
  }
  Content(const Content&) = delete;
  Content& operator=(const Content&) = delete;

  std::shared_ptr<const Reader::State> state;  ///< outlives the pins
  std::vector<PinnedBlock> pins;
};

PinnedVertices::PinnedVertices() noexcept = default;
PinnedVertices::~PinnedVertices() = default;
PinnedVertices::PinnedVertices(PinnedVertices&&) noexcept = default;
PinnedVertices& PinnedVertices::operator=(PinnedVertices&&) noexcept = default;

PinnedVertices Reader::pin_vertices(std::string_view attribute, int level, std::uint64_t first,
                                    std::uint64_t count) const try {
  const std::size_t number = state_->number_of(attribute);
  check_range(number, level, first, count);
  const BackendTraits& traits = state_->store->backend.traits;
  const bool addressed = traits.in_memory || (traits.maps_for_reading && !state_->store->writable);
  if (!addressed || count == 0)
    throw Error(addressed ? ErrorCode::kInvalidArgument : ErrorCode::kNotSupported,
                fmt::format("pin {} vertices of '{}': {}", count, attribute,
                            addressed ? "expected 1 or more"
                                      : "expected backend memory, or mmap opened for reading, "
                                        "found " +
                                            state_->store->options.backend));
  PinnedVertices vertices;
  vertices.content_ = std::make_unique<PinnedVertices::Content>(state_->share());
  while (count > 0) {
    PinnedBlock pinned;
    const std::span<const std::byte> bytes = read_vertices(number, level, first, count, pinned);
    const std::span<const std::byte> before = vertices.bytes_;
    if (!before.empty() && before.data() + before.size() != bytes.data()) break;
    vertices.bytes_ =
        before.empty() ? bytes : std::span(before.data(), before.size() + bytes.size());
    if (pinned) vertices.content_->pins.push_back(std::move(pinned));
    first += bytes.size() / record_bytes(number);
    count -= bytes.size() / record_bytes(number);
  }
  return vertices;
} catch (const std::bad_alloc&) {
  throw out_of_memory("pin vertices");
}

PLAIT_END_NAMESPACE
