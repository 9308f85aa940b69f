#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "compressed/filters/byte_planes.cpp"
#include "compressed/filters/byte_planes.h"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "compressed/filters/byte_planes-inl.h"

#if HWY_ONCE
namespace plait::byte_planes {

HWY_EXPORT(split_any);
HWY_EXPORT(join_any);

}  // namespace plait::byte_planes

PLAIT_BEGIN_PRIVATE_NAMESPACE

using namespace byte_planes;

void split_planes(const std::byte* numbers, std::size_t count, std::size_t width,
                  std::byte* planes) {
  HWY_DYNAMIC_DISPATCH(split_any)(numbers, count, width, planes);
}
void join_planes(const std::byte* planes, std::size_t count, std::size_t width,
                 std::byte* numbers) {
  HWY_DYNAMIC_DISPATCH(join_any)(planes, count, width, numbers);
}

PLAIT_END_NAMESPACE
#endif  // HWY_ONCE
