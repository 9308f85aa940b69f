// Large arrays in huge pages. A walk over a large mesh in no particular order then misses the
// processor's tables of pages less often, and the first touch of an array costs one page fault for
// two megabytes.
#pragma once

#include <cstddef>
#include <vector>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Asks the system for huge pages for the part of this memory that they can cover. A wish: if the
/// system does not grant it, nothing is different.
void wish_huge_pages(void* memory, std::size_t bytes) noexcept;

/// Reserves room for `count` elements. REQUIRES: the vector is empty. Errors: std::bad_alloc.
template <class Element>
void reserve_huge(std::vector<Element>& vector, std::size_t count) {
  vector.reserve(count);
  wish_huge_pages(vector.data(), vector.capacity() * sizeof(Element));
}

/// Errors: std::bad_alloc.
template <class Element>
std::vector<Element> huge_vector(std::size_t count, Element value = {}) {
  std::vector<Element> vector;
  reserve_huge(vector, count);
  vector.resize(count, value);
  return vector;
}

PLAIT_END_NAMESPACE
