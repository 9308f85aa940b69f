// What the code of docs/reading.md uses and does not declare. The page's code is the rest of a
// function, which tests/docs/CMakeLists.txt ends.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "plait/bounds.h"
#include "plait/create_store.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/store.h"

namespace page {

using Point = plait::Vector3<float>;
using Direction = plait::Vector3<double>;

void draw(const plait::PatchView& patch);
void keep(std::uint64_t vertex, std::span<const Point> records);
bool intersects(const plait::PatchView& patch, Direction eye, Direction direction);

void read(plait::FaceId face, std::int64_t i, std::int64_t j, std::span<const plait::FaceId> wanted,
          Direction eye, Direction direction, std::uint64_t first, std::uint64_t count);

}  // namespace page
