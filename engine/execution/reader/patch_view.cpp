// PatchView and RecordView: the records of a patch that read_patch() has pinned.

#include <fmt/format.h>

#include <cstddef>
#include <cstring>
#include <utility>

#include "address/record_sizes.h"
#include "execution/reader/reader_state.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

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

PLAIT_END_NAMESPACE
