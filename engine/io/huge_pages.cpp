#include "io/huge_pages.h"

#include <sys/mman.h>

#include <cstdint>

PLAIT_BEGIN_PRIVATE_NAMESPACE

void wish_huge_pages(void* memory, std::size_t bytes) noexcept {
  const std::size_t ahead = -reinterpret_cast<std::uintptr_t>(memory) % kHugePage;
  if (bytes < ahead + kHugePage) return;
  ::madvise(static_cast<std::byte*>(memory) + ahead, (bytes - ahead) / kHugePage * kHugePage,
            MADV_HUGEPAGE);
}

PLAIT_END_NAMESPACE
