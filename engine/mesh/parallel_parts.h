// parallel_parts.h: loops over faces and vertices in parts, on several threads, with the same
// results and errors as on one thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <vector>

#include "base/caught.h"
#include "base/interruption.h"
#include "base/threads.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

constexpr std::size_t kPartElements = std::size_t{1} << 14;

constexpr std::size_t part_count(std::size_t count) {
  return (count + kPartElements - 1) / kPartElements;
}

/// Calls body(first, last, part) for all parts of [0, count). Each part has kPartElements elements,
/// except the last. If some calls throw, the others still run; then for_parts() throws the
/// exception of the lowest part.
template <class Body>
void for_parts(std::size_t count, Body body) {
  std::vector<std::exception_ptr> failures(part_count(count));
  each_on_workers(std::size_t{0}, failures.size(), [&](std::size_t part) {
    poll_interruption();
    try {
      body(part * kPartElements, std::min((part + 1) * kPartElements, count), part);
    } catch (...) {
      failures[part] = caught_exception();
    }
  });
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

PLAIT_END_NAMESPACE
