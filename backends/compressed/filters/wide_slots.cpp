#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "compressed/filters/wide_slots.cpp"
#include "compressed/filters/wide_slots.h"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "compressed/filters/wide_slots-inl.h"

#if HWY_ONCE
namespace plait::wide_slots {

HWY_EXPORT(slots_at_once);
HWY_EXPORT(decode_slots);

}  // namespace plait::wide_slots

PLAIT_BEGIN_PRIVATE_NAMESPACE

using namespace wide_slots;

std::size_t wide_slots_at_once() { return HWY_DYNAMIC_DISPATCH(slots_at_once)(); }
void decode_wide_slots(SlotRule rule, const WideSlots& slots) {
  HWY_DYNAMIC_DISPATCH(decode_slots)(rule, slots);
}

PLAIT_END_NAMESPACE
#endif  // HWY_ONCE
