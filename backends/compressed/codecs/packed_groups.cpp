#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "compressed/codecs/packed_groups.cpp"
#include "compressed/codecs/packed_groups.h"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "compressed/codecs/packed_groups-inl.h"

#if HWY_ONCE
namespace plait::packed_groups {

HWY_EXPORT(group_widths);
HWY_EXPORT(pack);
HWY_EXPORT(unpack);

}  // namespace plait::packed_groups

PLAIT_BEGIN_PRIVATE_NAMESPACE

using namespace packed_groups;

void find_widths(const std::byte* words, std::size_t groups, std::uint32_t* widths) {
  HWY_DYNAMIC_DISPATCH(group_widths)(words, groups, widths);
}
void pack_groups(const std::byte* words, std::size_t groups, const std::uint32_t* widths,
                 std::byte* packed) {
  HWY_DYNAMIC_DISPATCH(pack)(words, groups, widths, packed);
}
void unpack_groups(const std::byte* packed, std::size_t bytes, const std::uint32_t* widths,
                   std::size_t groups, std::byte* words) {
  HWY_DYNAMIC_DISPATCH(unpack)(packed, bytes, widths, groups, words);
}

PLAIT_END_NAMESPACE
#endif  // HWY_ONCE
