#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "compressed/filters/column_rows.cpp"
#include "compressed/filters/column_rows.h"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "compressed/filters/column_rows-inl.h"

#if HWY_ONCE
namespace plait::slot_predictions {

HWY_EXPORT(has_rows);
HWY_EXPORT(encode_rows);
HWY_EXPORT(decode_rows);

}  // namespace plait::slot_predictions

PLAIT_BEGIN_PRIVATE_NAMESPACE

using namespace slot_predictions;

bool has_column_rows(const ColumnSlot& slot) { return HWY_DYNAMIC_DISPATCH(has_rows)(slot); }
void encode_column_rows(const ColumnSlot& slot, const float* numbers, std::uint32_t* words,
                        std::uint32_t* before) {
  HWY_DYNAMIC_DISPATCH(encode_rows)(slot, numbers, words, before);
}
void decode_column_rows(const ColumnSlot& slot, const std::uint32_t* words, float* numbers,
                        std::uint32_t* before) {
  HWY_DYNAMIC_DISPATCH(decode_rows)(slot, words, numbers, before);
}

PLAIT_END_NAMESPACE
#endif  // HWY_ONCE
