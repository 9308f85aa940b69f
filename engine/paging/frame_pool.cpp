#include "paging/frame_pool.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <new>
#include <utility>

#include "io/huge_pages.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kMostSlabBytes = std::size_t{8} << 20;
constexpr std::size_t kMostPlainSlabBytes = std::size_t{1} << 20;
constexpr std::uint64_t kLeastSlabs = 16;  ///< for which the budget must have room
/// A slab is mapped to the end of a huge page if that wastes at most one byte in this number.
constexpr std::size_t kBytesOfWaste = 128;
/// Each bare frame of a slab of huge pages may be a mapping of its own, and Linux allows a process
/// 65,530 of them.
constexpr std::size_t kMostFramesInHugePages = 32768;
// The address sanitizer would not see accesses beyond a frame.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kHasSlabs = false;
#elif defined(__has_feature)
constexpr bool kHasSlabs = !__has_feature(address_sanitizer);
#else
constexpr bool kHasSlabs = true;
#endif

std::byte* map_memory(std::size_t bytes) {
  void* const mapped =
      ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return mapped == MAP_FAILED ? nullptr : static_cast<std::byte*>(mapped);
}

/// Memory that begins at a huge page, or nullptr.
std::byte* map_huge_pages(std::size_t bytes) {
  std::byte* const mapped = map_memory(bytes + kHugePage);
  if (!mapped) return nullptr;
  // What is beside the slab must go: the system could make it part of a huge page.
  const std::size_t ahead = -reinterpret_cast<std::uintptr_t>(mapped) % kHugePage;
  std::byte* const memory = mapped + ahead;
  if (ahead > 0) ::munmap(mapped, ahead);
  ::munmap(memory + bytes, kHugePage - ahead);
  ::madvise(memory, bytes / kHugePage * kHugePage, MADV_HUGEPAGE);
  return memory;
}

/// Memory of which each page can be given back by itself, or nullptr.
std::byte* map_plain_pages(std::size_t bytes) {
  std::byte* const memory = map_memory(bytes);
  if (memory) ::madvise(memory, bytes, MADV_NOHUGEPAGE);
  return memory;
}

}  // namespace

FramePool::~FramePool() { release(); }

void FramePool::release() noexcept {
  for (auto& [bytes, size] : sizes_) {
    while (size.idle)
      if (std::byte* const memory = pop(size.idle); slab_of(memory) == slabs_.end())
        ::operator delete(memory, std::align_val_t(kAlignment));
    size.fresh.clear();
    size.bare.clear();
    size.in_slabs = 0;
  }
  for (const Slab& slab : slabs_) ::munmap(slab.memory, slab.bytes);
  slabs_.clear();
  frames_in_huge_pages_ = 0;
  idle_bytes_ = 0;
}

FramePool::SlabShape FramePool::huge_slab(std::uint64_t frame_bytes, std::uint64_t most_bytes) {
  SlabShape best;
  for (std::size_t frames = 1; frames * frame_bytes <= most_bytes; ++frames) {
    const std::size_t bytes = frames * frame_bytes;
    SlabShape shape{frames, bytes, bytes % kHugePage};
    const std::size_t missing = (kHugePage - shape.other_bytes) % kHugePage;
    if (missing <= bytes / kBytesOfWaste) shape = {frames, bytes + missing, missing};
    if (shape.bytes >= kHugePage &&
        shape.other_bytes * best.frames <= best.other_bytes * shape.frames)
      best = shape;
  }
  return best;
}

std::byte* FramePool::take_slab(Size& size, std::uint64_t bytes) {
  // Else the last page of a frame that is given back would be the first one of its neighbour.
  static const std::uint64_t page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  if (!kHasSlabs || bytes > kMostSlabBytes || bytes % page != 0) return nullptr;
  const std::size_t part = budget_bytes() / kLeastSlabs;
  const SlabShape huge = huge_slab(bytes, std::min(kMostSlabBytes, part));
  if (huge.frames > 0 && frames_in_huge_pages_ + huge.frames <= kMostFramesInHugePages)
    if (std::byte* const memory = map_slab(size, bytes, huge, true)) return memory;
  const std::size_t frames = std::min(kMostPlainSlabBytes, part) / bytes;
  return frames < 2 ? nullptr : map_slab(size, bytes, {frames, frames * bytes, 0}, false);
}

std::byte* FramePool::map_slab(Size& size, std::uint64_t bytes, const SlabShape& shape,
                               bool is_huge) {
  if (used_bytes_ + shape.frames * bytes > budget_bytes()) return nullptr;
  size.fresh.reserve(shape.frames);
  size.bare.reserve(size.in_slabs + shape.frames);
  slabs_.reserve(slabs_.size() + 1);
  make_room(shape.frames * bytes);
  std::byte* const memory = is_huge ? map_huge_pages(shape.bytes) : map_plain_pages(shape.bytes);
  if (!memory) return nullptr;
  slabs_.insert(std::ranges::upper_bound(slabs_, memory, {}, &Slab::memory),
                Slab{memory, shape.bytes, shape.frames, 0, is_huge});
  size.in_slabs += shape.frames;
  if (is_huge) frames_in_huge_pages_ += shape.frames;
  for (std::size_t frame = shape.frames; frame-- > 1;) size.fresh.push_back(memory + frame * bytes);
  idle_bytes_ += (shape.frames - 1) * bytes;
  return memory;
}

std::vector<FramePool::Slab>::iterator FramePool::slab_of(const std::byte* memory) noexcept {
  const auto after = std::ranges::upper_bound(slabs_, memory, {}, &Slab::memory);
  return after != slabs_.begin() && memory < after[-1].memory + after[-1].bytes ? after - 1
                                                                                : slabs_.end();
}

void FramePool::free_idle(Size& size, std::byte* memory, std::uint64_t bytes) noexcept {
  idle_bytes_ -= bytes;
  const auto slab = slab_of(memory);
  if (slab == slabs_.end()) return ::operator delete(memory, std::align_val_t(kAlignment));
  size.bare.push_back(memory);
  if (++slab->bare_frames == slab->frames) {
    std::erase_if(size.bare, [&](const std::byte* frame) {
      return frame >= slab->memory && frame < slab->memory + slab->bytes;
    });
    size.in_slabs -= slab->frames;
    if (slab->is_huge) frames_in_huge_pages_ -= slab->frames;
    ::munmap(slab->memory, slab->bytes);
    slabs_.erase(slab);
    return;
  }
  ::madvise(memory, bytes, MADV_DONTNEED);
  // Else the system could make the pages of a neighbour huge, over this frame.
  if (slab->is_huge) ::madvise(memory, bytes, MADV_NOHUGEPAGE);
}

std::byte* FramePool::take_bare(Size& size) noexcept {
  std::byte* const memory = size.bare.back();
  size.bare.pop_back();
  --slab_of(memory)->bare_frames;
  return memory;
}

std::byte* FramePool::pop(Idle*& list) noexcept {
  return reinterpret_cast<std::byte*>(std::exchange(list, list->next));
}

void FramePool::make_room(std::uint64_t bytes) noexcept {
  for (auto largest = sizes_.rbegin(); largest != sizes_.rend(); ++largest) {
    auto& [frame_bytes, size] = *largest;
    while (used_bytes_ + idle_bytes_ + bytes > budget_bytes()) {
      if (!size.fresh.empty()) {
        free_idle(size, size.fresh.back(), frame_bytes);
        size.fresh.pop_back();
      } else if (size.idle) {
        free_idle(size, pop(size.idle), frame_bytes);
      } else {
        break;
      }
    }
  }
}

std::byte* FramePool::take(std::uint64_t bytes) {
  Size& size = sizes_.find(bytes)->second;
  if (!may_use(bytes)) return nullptr;
  std::byte* memory = nullptr;
  if (size.idle) {
    memory = pop(size.idle);
    idle_bytes_ -= bytes;
  } else if (!size.fresh.empty()) {
    memory = size.fresh.back();
    size.fresh.pop_back();
    idle_bytes_ -= bytes;
  } else if (!size.bare.empty()) {
    make_room(bytes);
    memory = take_bare(size);
  } else if (memory = take_slab(size, bytes); !memory) {
    make_room(bytes);
    memory = static_cast<std::byte*>(::operator new(bytes, std::align_val_t(kAlignment)));
  }
  used_bytes_ += bytes;
  peak_bytes_ = std::max(peak_bytes_, used_bytes_);
  return memory;
}

void FramePool::give_back(std::byte* memory, std::uint64_t bytes) noexcept {
  used_bytes_ -= bytes;
  idle_bytes_ += bytes;
  Idle*& list = sizes_.find(bytes)->second.idle;
  list = new (memory) Idle{list};
}

bool FramePool::reserve(std::uint64_t bytes) noexcept {
  if (!may_use(bytes)) return false;
  make_room(bytes);
  used_bytes_ += bytes;
  peak_bytes_ = std::max(peak_bytes_, used_bytes_);
  return true;
}

void FramePool::set_aside(std::uint64_t bytes) noexcept {
  aside_bytes_ = std::min(bytes, budget_bytes_);
  if (used_bytes_ <= budget_bytes()) make_room(0);
}

void FramePool::lend(std::int64_t bytes) noexcept {
  lent_bytes_ += static_cast<std::uint64_t>(bytes);
  if (used_bytes_ <= budget_bytes()) make_room(0);
}

PLAIT_END_NAMESPACE
